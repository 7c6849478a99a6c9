"""The classes that describe a case (numbers, forms, metric, samples, scene), and the registry of cases by name."""

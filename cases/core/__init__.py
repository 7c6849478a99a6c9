"""What a case is: numbers, forms, metric, samples, scene; cases by name."""

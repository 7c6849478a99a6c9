"""What is measured beside a run: orders, growth of errors, pairs, benchmarks."""

"""Studies beside a run: convergence orders, growth of errors, pairs at equal error, benchmarks, model hierarchies."""

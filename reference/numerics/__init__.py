"""Numbers, series, special functions, quadratures and tables from which exact motions are computed."""

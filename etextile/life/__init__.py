"""Life statistics: lives with what is censored in them, Weibull and lognormal fits, curves without a distribution."""

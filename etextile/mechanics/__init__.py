"""Energy contributions, the model that collects them and the compiled kernels."""

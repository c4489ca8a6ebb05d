import common  # noqa: F401 (finds the helpers of tests)

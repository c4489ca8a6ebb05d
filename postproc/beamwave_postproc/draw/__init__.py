"""One picture a module: functions from xarray datasets to matplotlib figures."""

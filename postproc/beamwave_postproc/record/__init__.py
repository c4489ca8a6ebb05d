"""Histories of laboratories, as UFF 58, MATLAB, NumPy and sound files hold them, into NetCDF files for `&record`."""

from .channels import Channel, NotARecord, Wanted
from .readers import read_channels
from .write import write_record

__all__ = ["Channel", "NotARecord", "Wanted", "read_channels", "write_record"]

module bw_kinds
  !! Kinds of numbers used throughout.
  use, intrinsic :: iso_fortran_env, only: int8, int32, int64, real64, real128
  implicit none (type, external)
  private
  integer, parameter, public :: dp = real64   !! working precision: IEEE binary64
  integer, parameter, public :: qp = real128  !! extended precision, only where binary64 does not suffice
  integer, parameter, public :: i1 = int8
  integer, parameter, public :: i4 = int32
  integer, parameter, public :: i8 = int64
end module bw_kinds

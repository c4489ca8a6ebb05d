module bw_constants
  !! Numbers that mathematics gives.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  real(dp), parameter, public :: pi = acos(-1.0_dp)
  real(dp), parameter, public :: two_pi = 2.0_dp*pi
end module bw_constants

module bw_constants
  !! Mathematical constants.
  use bw_kinds, only: dp, qp
  implicit none (type, external)
  private
  real(qp), parameter, public :: qp_pi = acos(-1.0_qp)
  real(dp), parameter, public :: pi = real(qp_pi, dp)
  real(dp), parameter, public :: two_pi = 2.0_dp*pi
  real(dp), parameter, public :: gravity = 9.80665_dp   !! standard gravity, m/s²
end module bw_constants

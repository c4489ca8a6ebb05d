module bw_mode_demand
  !! What is asked of modes by strains beside their frequencies and shapes, and how many digits these need.
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  type, public :: mode_demand
    integer :: digits = 11
      !! of shapes: in a norm of 1 their last coefficients are below 10^(−digits). Frequencies err by about the square of that, but
      !! not by less than rounding.
    logical :: waves = .true.
      !! wave numbers, velocities and the critical speed; without them their arrays stay unallocated and the speed is 0
  contains
    procedure :: negligible
    procedure :: ends
  end type mode_demand

contains

  pure real(dp) function negligible(self)
    !! Last coefficients of a resolved mode.
    class(mode_demand), intent(in) :: self
    negligible = 10.0_dp**(-self%digits)
  end function negligible

  pure integer function ends(self, of_all_digits)
    !! Functions that the ends of a beam or of a piece need beside those of its waves; errors fall exponentially with them.
    class(mode_demand), intent(in) :: self
    integer, intent(in) :: of_all_digits        !! those of 11 digits
    ends = (of_all_digits*self%digits + 10)/11
  end function ends

end module bw_mode_demand

module bw_mode_set
  !! A set of modes, whichever way they were found: what events, response and results ask of them.
  !!
  !! Everything is without dimensions: lengths in l, times in l²/h, masses in the beam's mass m_i.
  use bw_kinds, only: dp
  use bw_double_double, only: dd
  implicit none (type, external)
  private

  type, abstract, public :: mode_set
    integer :: count = 0                          !! number of modes n
    real(dp), allocatable :: alpha(:)             !! α = P l, wave number times length, (n)
    type(dd), allocatable :: beta_squared(:)      !! β², > 0 stable, 0 critical, < 0 growing, (n)
    real(dp), allocatable :: tip(:)               !! Φ_k(1), (n)
    real(dp), allocatable :: modal_mass(:)        !! M_k, (n)
    real(dp), allocatable :: phase_velocity(:)    !! C_p, Eq. 32, missing where it does not exist, (n)
    real(dp), allocatable :: group_velocity(:)    !! C_g, Eq. 33, missing where it does not exist, (n)
    type(dd) :: critical_speed                    !! lowest ω at which a mode is unstable; 0 where there is none
  contains
    procedure(shapes_interface), deferred :: shapes
  end type mode_set

  abstract interface
    pure function shapes_interface(self, xi) result(values)
      !! Φ_k(ξ) at points of the beam.
      import :: mode_set, dp
      implicit none (type, external)
      class(mode_set), intent(in) :: self
      real(dp), intent(in) :: xi(:)               !! 0 ≤ ξ ≤ 1, (points)
      real(dp) :: values(self%count, size(xi))    !! (modes, points)
    end function shapes_interface
  end interface

end module bw_mode_set

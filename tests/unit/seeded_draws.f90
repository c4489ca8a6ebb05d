module seeded_draws
  !! Random numbers of tests that draw many cases from a seed. BEAMWAVE_DRAWS multiplies how many they draw, by hand.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: draws_of, normal, start_draws

  integer, parameter :: first_numbers = 40   !! of a generator, dropped: neighbouring seeds begin alike

contains

  subroutine start_draws(seed)
    !! Begin the compiler's random numbers anew.
    integer, intent(in) :: seed
    integer, allocatable :: seeds(:)
    integer :: n
    real(dp) :: drop(first_numbers)
    call random_seed(size=n)
    allocate (seeds(n), source=7919*seed + 13)
    call random_seed(put=seeds)
    call random_number(drop)
  end subroutine start_draws

  integer function draws_of(few)
    !! A number of draws, times BEAMWAVE_DRAWS.
    integer, intent(in) :: few
    character(12) :: text
    integer :: status, factor
    call get_environment_variable('BEAMWAVE_DRAWS', text, status=status)
    factor = 1
    if (status == 0) read (text, *) factor
    draws_of = few*factor
  end function draws_of

  real(dp) function normal()
    !! A number of mean 0 and deviation 1 (Box and Muller).
    real(dp) :: radius, angle
    call random_number(radius)
    call random_number(angle)
    normal = sqrt(-2*log(1 - radius))*cos(2*pi*angle)
  end function normal

end module seeded_draws

module random_streams
  !! Random numbers for tests: the same from the same seed on every machine.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: stream_of_environment

  integer(i8), parameter :: default_seed = 20020917_i8
  integer(i8), parameter :: modulus = 2_i8**31

  type, public :: random_stream
    !! A linear congruential generator, of which the upper bits are used.
    integer(i8) :: state = default_seed
  contains
    procedure :: below
    procedure :: chance
    procedure :: between
    procedure :: log_between
    procedure :: real_bits
    procedure :: seed_text
  end type random_stream

contains

  type(random_stream) function stream_of_environment() result(stream)
    !! A stream whose seed is the environment variable BEAMWAVE_SEED, a whole number ≥ 0, where it is set.
    character(24) :: text
    integer(i8) :: seed
    integer :: length, stat
    call get_environment_variable('BEAMWAVE_SEED', text, length, stat)
    if (stat /= 0 .or. length == 0) return
    read (text, *, iostat=stat) seed
    if (stat == 0) stream%state = modulo(seed, modulus)
  end function stream_of_environment

  function seed_text(self) result(text)
    !! What to set to get the numbers from here on again.
    class(random_stream), intent(in) :: self
    character(:), allocatable :: text
    character(40) :: buffer
    write (buffer, '(a,i0)') 'BEAMWAVE_SEED=', self%state
    text = trim(buffer)
  end function seed_text

  integer function below(self, n)
    !! A number 0 … n − 1, n ≤ 2²².
    class(random_stream), intent(inout) :: self
    integer, intent(in) :: n
    self%state = mod(1103515245_i8*self%state + 12345_i8, modulus)
    below = int(mod(self%state/2_i8**8, int(n, i8)))
  end function below

  logical function chance(self, percent)
    !! True so many times in a hundred.
    class(random_stream), intent(inout) :: self
    integer, intent(in) :: percent
    chance = self%below(100) < percent
  end function chance

  real(dp) function between(self, low, high)
    !! Uniform in low … high.
    class(random_stream), intent(inout) :: self
    real(dp), intent(in) :: low, high
    real(dp) :: part
    part = self%below(2**22)*2.0_dp**(-22)
    part = part + self%below(2**22)*2.0_dp**(-44)
    between = low + (high - low)*part
  end function between

  real(dp) function log_between(self, low, high)
    !! A positive number whose logarithm is uniform.
    class(random_stream), intent(inout) :: self
    real(dp), intent(in) :: low, high
    log_between = exp(self%between(log(low), log(high)))
  end function log_between

  real(dp) function real_bits(self, least, most)
    !! A positive number with random bits and an exponent between two powers of two.
    class(random_stream), intent(inout) :: self
    integer, intent(in) :: least, most
    real(dp) :: fraction
    fraction = 0.5_dp + self%below(2**22)*2.0_dp**(-23)
    fraction = fraction + self%below(2**22)*2.0_dp**(-45) + self%below(2**8)*2.0_dp**(-53)
    real_bits = scale(fraction, least + self%below(most - least + 1))
  end function real_bits

end module random_streams

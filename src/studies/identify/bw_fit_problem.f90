module bw_fit_problem
  !! The least-squares problem of the unknowns: residuals between measured lines and the modes of their beams.
  !!
  !! An unknown x is mapped from its range to v = −1 … 1, linearly in x, or in ln x if the range spans decades. A line's
  !! residual is (f_line − f)/√(s² + τ²f_line²), with its standard deviation s and the model's relative scatter τ.
  !! Decays have residuals if damping is unknown. Complex amplitudes of a line at several sensors have residuals against
  !! the mode's shape times the complex factor that fits best; modal constants of a measured blow need no such factor.
  !! Amplitudes have an error relative to the largest one beside their noise, as frequencies have τ.
  use bw_measured_state, only: amplitude_weights, measured_state, sensor_error, state_modes, vague_deviation
  use bw_identify_par, only: identify_par
  use bw_kinds, only: dp
  use bw_least_squares, only: least_squares, residual_problem
  use bw_line_assignment, only: frequency_band, best_scatter, pairing
  implicit none (type, external)
  private
  public :: problem_of, position_in, value_at, is_at_end

  real(dp), parameter :: impossible = 1.0e6_dp   !! residual of each line where unknowns make no beam
  real(dp), parameter, public :: model_accuracy = 1.0e-13_dp   !! relative, of frequencies
  type, extends(residual_problem), public :: fit_problem
    type(identify_par), allocatable :: unknowns(:)
    type(measured_state), allocatable :: states(:)
    real(dp) :: scatter = 0.0_dp                 !! τ
    real(dp) :: amplitude_error = sensor_error   !! beside noise, relative to the largest amplitude of a line
    logical :: fits_decay = .false.
    real(dp), allocatable :: v(:)                !! of all unknowns, (unknowns)
    integer, allocatable :: free(:)              !! the unknowns that vary
    integer, allocatable, private :: twin(:)     !! the first state with the same modes, (states)
    integer :: evaluations = 0
  contains
    procedure :: find_residuals
    procedure :: count => count_residuals
    procedure :: count_tested
    procedure :: amplitude_freedom
    procedure :: pairs
    procedure :: match
    procedure :: minimise
    procedure :: find_derivatives
    procedure :: values => values_of_problem
  end type fit_problem

contains

  type(fit_problem) function problem_of(states, unknowns) result(problem)
    !! Set up the problem. Decays have residuals if damping parameters are unknown.
    type(measured_state), intent(in) :: states(:)
    type(identify_par), intent(in) :: unknowns(:)
    integer :: i, j
    problem%unknowns = unknowns
    problem%states = states
    problem%fits_decay = any([(index(unknowns(i)%parameter, 'damping%') == 1, i=1, size(unknowns))])
    allocate (problem%v(size(unknowns)), source=0.0_dp)
    problem%free = [(i, i=1, size(unknowns))]
    allocate (problem%twin(size(states)))
    do i = 1, size(states)
      problem%twin(i) = i
      do j = 1, i - 1
        if (problem%twin(j) == j .and. states(i)%is_twin_of(states(j))) exit
      end do
      problem%twin(i) = j
    end do
  end function problem_of

  elemental real(dp) function value_at(unknown, v) result(x)
    !! Return the value of an unknown.
    type(identify_par), intent(in) :: unknown
    real(dp), intent(in) :: v
    real(dp) :: way
    way = min(1.0_dp, max(0.0_dp, 0.5_dp + 0.5_dp*v))
    if (unknown%logarithmic) then
      x = exp((1 - way)*log(unknown%first) + way*log(unknown%last))
    else
      x = (1 - way)*unknown%first + way*unknown%last
    end if
    x = min(unknown%last, max(unknown%first, x))
  end function value_at

  elemental real(dp) function position_in(unknown, x) result(v)
    !! Return the position of a value in the range of its unknown, −1 … 1.
    type(identify_par), intent(in) :: unknown
    real(dp), intent(in) :: x
    if (unknown%logarithmic) then
      v = 2*log(x/unknown%first)/log(unknown%last/unknown%first) - 1
    else
      v = 2*(x - unknown%first)/(unknown%last - unknown%first) - 1
    end if
    v = min(1.0_dp, max(-1.0_dp, v))
  end function position_in

  elemental logical function is_at_end(v)
    !! Return whether an unknown is at an end of its range.
    real(dp), intent(in) :: v
    real(dp), parameter :: end = 0.999_dp        !! fraction of half the range that counts as its end
    is_at_end = abs(v) > end
  end function is_at_end

  pure function values_of_problem(self) result(values)
    !! Return the values of all unknowns.
    class(fit_problem), intent(in) :: self
    real(dp) :: values(size(self%unknowns))
    values = value_at(self%unknowns, self%v)
  end function values_of_problem

  pure integer function count_residuals(self) result(count)
    !! Count residuals: one per line that is a mode, one per decay if damping is unknown, two per amplitude at a sensor.
    class(fit_problem), intent(in) :: self
    integer :: i
    count = self%count_tested()
    do i = 1, size(self%states)
      associate (state => self%states(i))
        if (allocated(state%lines%points)) count = count + 2*size(state%lines%points)*counted(state%mode_of)
      end associate
    end do
  end function count_residuals

  pure integer function count_tested(self) result(count)
    !! Count the residuals that test a model. They precede those of amplitudes, whose errors are poorly known.
    class(fit_problem), intent(in) :: self
    integer :: i
    count = 0
    do i = 1, size(self%states)
      count = count + merge(2, 1, self%fits_decay)*counted(self%states(i)%mode_of)
    end do
  end function count_tested

  pure integer function amplitude_freedom(self) result(freedom)
    !! Return residuals of amplitudes, less the complex factor of each line whose blow is unknown.
    class(fit_problem), intent(in) :: self
    integer :: i
    freedom = self%count() - self%count_tested()
    do i = 1, size(self%states)
      associate (state => self%states(i))
        if (allocated(state%lines%points) .and. .not. state%lines%over_blow) freedom = freedom - 2*counted(state%mode_of)
      end associate
    end do
  end function amplitude_freedom

  pure integer function counted(mode_of)
    !! Count the lines that are modes.
    integer, intent(in) :: mode_of(:)
    counted = count(mode_of > 0)
  end function counted

  subroutine find_residuals(self, v, residuals)
    !! Find the residuals of all lines that are modes, in the order of states and lines; decays follow frequencies,
    !! amplitudes come last.
    class(fit_problem), intent(inout) :: self
    real(dp), intent(in) :: v(:)                 !! of the free unknowns
    real(dp), intent(out) :: residuals(:)
    type(state_modes) :: modes
    integer, allocatable :: line(:)
    real(dp) :: all_v(size(self%v))
    integer :: i, k, n, m
    self%evaluations = self%evaluations + 1
    all_v = self%v
    all_v(self%free) = v
    residuals = 0
    n = 0
    m = self%count_tested()
    do i = 1, size(self%states)
      associate (state => self%states(i), lines => self%states(i)%lines)
        line = pack([(k, k=1, size(state%mode_of))], state%mode_of > 0)
        call modes_of_twin(self, i, value_at(self%unknowns, all_v), state%mode_of(line), modes)
        do k = 1, size(line)
          n = n + 1
          residuals(n) = impossible
          if (modes%found) residuals(n) = (lines%frequency(line(k)) - modes%frequency(k)) &
            /sqrt(lines%deviation(line(k))**2 + (self%scatter*lines%frequency(line(k)))**2)
        end do
        if (allocated(lines%points)) then
          do k = 1, size(line)
            if (modes%found) call put_amplitudes(lines%amplitude(:, line(k)), lines%amplitude_deviation(:, line(k)), &
              modes%shape(k, :), lines%over_blow, self%amplitude_error, residuals(m + 1:m + 2*size(lines%points)))
            m = m + 2*size(lines%points)
          end do
        end if
        if (.not. self%fits_decay) cycle
        do k = 1, size(line)
          n = n + 1
          residuals(n) = impossible
          if (modes%found) residuals(n) = (lines%decay(line(k)) - modes%decay(k)) &
            /sqrt(lines%decay_deviation(line(k))**2 + (self%scatter*lines%decay(line(k)))**2)
        end do
      end associate
    end do
  end subroutine find_residuals

  subroutine modes_of_twin(self, i, values, number, modes)
    !! Find modes of state i, for all its twins together.
    type(fit_problem), intent(inout) :: self
    integer, intent(in) :: i
    real(dp), intent(in) :: values(:)
    integer, intent(in) :: number(:)
    type(state_modes), intent(out) :: modes
    logical, allocatable :: needed(:)
    integer :: j, k, leader
    leader = self%twin(i)
    if (leader == i .and. count(self%twin == i) > 1) then
      allocate (needed(self%states(i)%most_modes), source=.false.)
      do j = 1, size(self%states)
        if (self%twin(j) == i) needed(pack(self%states(j)%mode_of, self%states(j)%mode_of > 0)) = .true.
      end do
      call self%states(i)%modes_at(values, pack([(k, k=1, size(needed))], needed), modes)
    end if
    call self%states(leader)%modes_at(values, number, modes)
  end subroutine modes_of_twin

  pure subroutine put_amplitudes(amplitude, deviation, shape, over_blow, error, residuals)
    !! Put residuals of the amplitudes of one line, real and imaginary parts. The complex factor is fitted unless the
    !! blow is known.
    complex(dp), intent(in) :: amplitude(:)      !! (sensors)
    real(dp), intent(in) :: deviation(:), shape(:)
    logical, intent(in) :: over_blow             !! amplitudes are modal constants
    real(dp), intent(in) :: error                !! beside the deviation, relative to the largest amplitude
    real(dp), intent(out) :: residuals(:)        !! (2 sensors)
    complex(dp) :: scale, left(size(amplitude))
    real(dp) :: weight(size(amplitude))
    integer :: s
    s = size(amplitude)
    weight = amplitude_weights(amplitude, deviation, error)
    scale = sum(weight*shape*amplitude)/max(sum(weight*shape**2), tiny(1.0_dp))
    if (over_blow) scale = 1
    left = sqrt(weight)*(amplitude - scale*shape)
    residuals(:s) = left%re
    residuals(s + 1:) = left%im
  end subroutine put_amplitudes

  subroutine pairs(self, records, band)
    !! Return the lines of all states, and their modes at the present unknowns, to somewhat above the highest line.
    class(fit_problem), intent(inout) :: self
    type(pairing), allocatable, intent(out) :: records(:)
    type(frequency_band), intent(out) :: band
    integer, parameter :: at_once = 4
    real(dp), parameter :: beyond = 1.1_dp       !! times the highest line: limit of the modes sought
    type(state_modes) :: modes
    real(dp) :: low, high
    integer :: i, k, n, lines
    allocate (records(size(self%states)))
    low = huge(low)
    high = 0
    lines = 0
    do i = 1, size(self%states)
      associate (state => self%states(i), frequency => self%states(i)%lines%frequency)
        if (size(frequency) == 0) cycle
        low = min(low, frequency(1))
        high = max(high, frequency(size(frequency)))
        lines = lines + size(frequency)
        n = min(size(frequency) + at_once, state%most_modes)
        do
          call self%states(self%twin(i))%modes_at(self%values(), [(k, k=1, n)], modes)
          if (.not. modes%found .or. n == state%most_modes) exit
          if (modes%frequency(n) > beyond*frequency(size(frequency))) exit
          n = min(n + at_once, state%most_modes)
        end do
        records(i)%line = frequency
        records(i)%deviation = state%lines%deviation/frequency
        records(i)%spurious = state%is_harmonic .or. records(i)%deviation > vague_deviation
        records(i)%chance = state%chance
        records(i)%mode = modes%frequency
        if (.not. modes%found) records(i)%mode = -records(i)%mode
      end associate
    end do
    do i = 1, size(self%states)
      if (allocated(records(i)%line)) cycle
      records(i)%line = self%states(i)%lines%frequency
      records(i)%deviation = records(i)%line
      records(i)%mode = records(i)%line
      records(i)%spurious = self%states(i)%is_harmonic
      records(i)%chance = self%states(i)%chance
    end do
    band%width = 1 + log(max(high/low, 1.0_dp))
    band%share = max(0.0_dp, 1 - size(self%unknowns)/real(max(1, lines), dp))
  end subroutine pairs

  subroutine match(self, least, penalty, changed)
    !! Assign lines to modes at the present unknowns and set τ, both by least penalty.
    class(fit_problem), intent(inout) :: self
    real(dp), intent(in) :: least                !! lower bound of τ
    real(dp), intent(out) :: penalty
    logical, intent(out) :: changed              !! the assignment has changed
    type(pairing), allocatable :: records(:)
    type(frequency_band) :: band
    integer :: i
    call self%pairs(records, band)
    call best_scatter(records, band, least, self%scatter, penalty)
    changed = .false.
    do i = 1, size(self%states)
      changed = changed .or. any(records(i)%mode_of /= self%states(i)%mode_of)
      self%states(i)%mode_of = records(i)%mode_of
    end do
  end subroutine match

  subroutine minimise(self, residuals, quick)
    !! Vary the free unknowns to minimise the sum of squares at a fixed assignment.
    class(fit_problem), intent(inout) :: self
    real(dp), allocatable, intent(out) :: residuals(:)
    logical, intent(in) :: quick                 !! converge to a thousandth of the sum, else fully
    real(dp), parameter :: rough = 1.0e-4_dp, fine = 1.0e-9_dp
    real(dp) :: v(size(self%free))
    v = self%v(self%free)
    if (size(v) == 0 .or. self%count() == 0) then
      allocate (residuals(self%count()))
      call self%find_residuals(v, residuals)
      return
    end if
    call least_squares(self, self%count(), model_accuracy, merge(rough, fine, quick), v, residuals)
    self%v(self%free) = v
  end subroutine minimise

  subroutine find_derivatives(self, jacobian)
    !! Find derivatives of the residuals by all unknowns, by central differences.
    class(fit_problem), intent(inout) :: self
    real(dp), allocatable, intent(out) :: jacobian(:, :)     !! (residuals, unknowns)
    real(dp), parameter :: step = 1.0e-5_dp
    real(dp) :: v(size(self%v)), up(self%count()), down(self%count()), high
    integer :: i
    allocate (jacobian(self%count(), size(self%v)))
    do i = 1, size(self%v)
      v = self%v
      v(i) = min(1.0_dp, self%v(i) + step)
      high = v(i)
      call self%find_residuals(v, up)
      v(i) = max(-1.0_dp, self%v(i) - step)
      call self%find_residuals(v, down)
      jacobian(:, i) = (up - down)/(high - v(i))
    end do
  end subroutine find_derivatives

end module bw_fit_problem

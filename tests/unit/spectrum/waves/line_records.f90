module line_records
  !! Random records of 2 to 10 lines, 0.5 to 50 periods long, spaced by 0.1 to 3 periods over the record, and what the
  !! analysis makes of them.
  use bw_kinds, only: dp, qp
  use bw_measured, only: measure_waves, measured_type
  use bw_mode_check, only: record_facts
  implicit none (type, external)
  private
  public :: judge_records

  real(qp), parameter :: pi = acos(-1.0_qp)
  integer, parameter :: most = 10              !! lines
  integer, parameter :: families = 6
  integer, parameter :: first_numbers = 20     !! of a generator, dropped: neighbouring seeds begin alike

  type :: record_type
    integer :: lines = 0, samples = 0
    real(dp) :: position(most) = 0, tip(most) = 0, midpoint(most) = 0, phase(most) = 0, growth(most) = 0
  end type record_type

  type, public :: verdict_type
    !! On many records.
    integer :: peaks = 0         !! found
    integer :: violations = 0    !! peaks that no line is within the bound of
    integer :: pairs = 0         !! of lines closer than 1/T
    integer :: named = 0         !! such pairs within the bound, of at least 1/T, of one peak
  end type verdict_type

contains

  type(verdict_type) function judge_records(count) result(verdict)
    !! The first `count` records, each family in turn.
    integer, intent(in) :: count
    integer :: i
    do i = 1, count
      call judge(record_of(1 + mod(i - 1, families), i), verdict)
    end do
  end function judge_records

  type(record_type) function record_of(family, seed) result(record)
    integer, intent(in) :: family, seed
    call seed_with(seed)
    record = random_record()
    associate (last => record%position(record%lines))
      select case (family)
      case (1)           ! hardly twice as many samples as the last line has periods
        record%samples = nint(2.2_dp*last) + 16 + int(40*chance())
      case (2)           ! a line at 0
        record%position(1) = 0
      case (3)           ! a line at the Nyquist frequency
        record%samples = 2*(record%samples/2)
        last = record%samples/2
      case (4)           ! the last line is folded onto the first
        last = record%samples - record%position(1)
      case (5)           ! lines that decay
        call random_number(record%growth(:record%lines))
        record%growth = -3*record%growth
      case default       ! plain lines
      end select
    end associate
  end function record_of

  type(record_type) function random_record() result(record)
    real(dp) :: next
    integer :: i
    record%lines = 2 + int(9*chance())
    record%samples = 2**(8 + int(5*chance())) + int(3*chance())
    next = 0.5_dp*100**chance()
    do i = 1, record%lines
      record%position(i) = next
      next = next + 0.1_dp + 2.9_dp*chance()
      record%tip(i) = 10**(-3*chance())
      record%midpoint(i) = 3*(2*chance() - 1)*record%tip(i)
      record%phase(i) = 2*real(pi, dp)*chance()
    end do
  end function random_record

  real(dp) function chance()
    call random_number(chance)
  end function chance

  subroutine seed_with(number)
    integer, intent(in) :: number
    integer, allocatable :: seed(:)
    real(dp) :: drop(first_numbers)
    integer :: length
    call random_seed(size=length)
    allocate (seed(length), source=number)
    call random_seed(put=seed)
    call random_number(drop)
  end subroutine seed_with

  function histories(record) result(samples)
    !! Tip and midpoint; phases reduced before they are rounded.
    type(record_type), intent(in) :: record
    real(dp) :: samples(0:record%samples - 1, 2), tone
    real(qp) :: periods
    integer :: i, j
    samples = 0
    do i = 1, record%lines
      do j = 0, record%samples - 1
        periods = real(record%position(i), qp)*j/record%samples
        tone = sin(real(2*pi*(periods - anint(periods)), dp) + record%phase(i))*exp(record%growth(i)*j/record%samples)
        samples(j, :) = samples(j, :) + [record%tip(i), record%midpoint(i)]*tone
      end do
    end do
  end function histories

  subroutine judge(record, verdict)
    type(record_type), intent(in) :: record
    type(verdict_type), intent(inout) :: verdict
    type(measured_type) :: found
    real(dp), allocatable :: samples(:, :), position(:)
    logical, allocatable :: named(:)
    integer :: i
    allocate (samples, source=histories(record))
    call measure_waves(samples(:, 1), samples(:, 2), record_facts(2*real(pi, dp), max_peaks=99, ends=''), found)
    allocate (position, source=record%position(:record%lines))
    position = abs(position - record%samples*anint(position/record%samples))
    verdict%peaks = verdict%peaks + found%peak_count
    allocate (named(found%peak_count))
    associate (frequency => found%angular_frequency, error => found%angular_frequency_error)
      do i = 1, found%peak_count
        if (all(abs(position - frequency(i)) > error(i))) verdict%violations = verdict%violations + 1
      end do
      do i = 1, record%lines - 1
        if (abs(position(i + 1) - position(i)) >= 1) cycle
        verdict%pairs = verdict%pairs + 1
        named = abs(position(i) - frequency) <= error .and. abs(position(i + 1) - frequency) <= error .and. error >= 1
        if (any(named)) verdict%named = verdict%named + 1
      end do
    end associate
  end subroutine judge

end module line_records

module bw_samples
  !! Samples of one motion at several sensors, at even or uneven times. Time is counted in steps from the first sample.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: first_valid, gaps_of, keep_sensors, part_of, place_of, runs_of, set_missing, span_of, validity

  type, public :: gaps_type
    integer, allocatable :: place(:)         !! invalid samples of a sensor, ascending
  end type gaps_type

  type, public :: samples_type
    integer :: count = 0                     !! N
    real(dp) :: step = 1                     !! s; of uneven times the median
    real(dp), allocatable :: place(:)        !! times of the samples, ascending from 0, (N); unallocated: 0, 1, 2, …
    integer, allocatable :: row(:)           !! numbers of the recorded samples, ascending from 1; unallocated: all were recorded
    real(dp), allocatable :: value(:, :)     !! (N or more, S)
    logical, allocatable :: left_out(:)      !! sensors without which lines are found, (S); unallocated: none
    type(gaps_type), allocatable :: missing(:)  !! invalid samples of each sensor, (S); unallocated: all are valid
    integer, allocatable :: blow(:)          !! first samples after known blows; unallocated: blows are searched for
    logical :: pure = .false.                !! known to hold lines and rounding but no noise, as a simulation's
  end type samples_type

contains

  pure real(dp) function span_of(samples)
    !! The length of the record in steps; N if times are even.
    type(samples_type), intent(in) :: samples
    span_of = samples%count
    if (allocated(samples%place)) span_of = samples%place(samples%count) + 1
  end function span_of

  pure real(dp) function place_of(samples, n)
    !! The time of sample n, counted from 1.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: n
    place_of = n - 1
    if (allocated(samples%place)) place_of = samples%place(n)
  end function place_of

  pure type(samples_type) function part_of(samples, first, last) result(part)
    !! The samples from one to another.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: first, last
    integer :: s
    part%count = last - first + 1
    part%step = samples%step
    part%value = samples%value(first:last, :)
    if (allocated(samples%place)) part%place = samples%place(first:last) - samples%place(first)
    if (allocated(samples%blow)) part%blow = pack(samples%blow, samples%blow >= first .and. samples%blow <= last) - first + 1
    if (.not. allocated(samples%missing)) return
    part%missing = samples%missing
    do s = 1, size(part%missing)
      associate (place => samples%missing(s)%place)
        part%missing(s)%place = pack(place, place >= first .and. place <= last) - first + 1
      end associate
    end do
  end function part_of

  pure subroutine keep_sensors(kept, samples)
    !! Keep the samples of some sensors only.
    integer, intent(in) :: kept(:)           !! sensors in their new order
    type(samples_type), intent(inout) :: samples
    real(dp), allocatable :: value(:, :)
    integer :: s
    allocate (value(size(samples%value, 1), size(kept)))
    do s = 1, size(kept)
      value(:, s) = samples%value(:, kept(s))
    end do
    call move_alloc(value, samples%value)
    if (allocated(samples%missing)) samples%missing = samples%missing(kept)
  end subroutine keep_sensors

  pure function validity(samples, s) result(valid)
    !! Which samples of a sensor are valid, (N).
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: s
    logical :: valid(samples%count)
    valid = .true.
    if (allocated(samples%missing)) valid(samples%missing(s)%place) = .false.
  end function validity

  pure integer function first_valid(samples) result(first)
    !! The first sample that is valid at any sensor.
    type(samples_type), intent(in) :: samples
    integer :: s, n
    first = 1
    if (.not. allocated(samples%missing)) return
    first = samples%count
    do s = 1, size(samples%missing)
      associate (place => samples%missing(s)%place)
        n = 1
        do while (n <= size(place))
          if (place(n) > n) exit
          n = n + 1
        end do
      end associate
      first = min(first, n)
    end do
  end function first_valid

  pure type(gaps_type) function gaps_of(valid) result(gaps)
    !! The invalid samples of a sensor.
    logical, intent(in) :: valid(:)
    integer :: n
    gaps%place = pack([(n, n=1, size(valid))], .not. valid)
  end function gaps_of

  pure subroutine set_missing(gaps, samples)
    !! Take the invalid samples of each sensor.
    type(gaps_type), intent(in) :: gaps(:)   !! (S)
    type(samples_type), intent(inout) :: samples
    integer :: s
    if (allocated(samples%missing)) deallocate (samples%missing)
    if (any([(size(gaps(s)%place) > 0, s=1, size(gaps))])) samples%missing = gaps
  end subroutine set_missing

  pure function runs_of(valid, first, last) result(runs)
    !! First and last sample of each run of valid samples between two samples, (2, runs).
    logical, intent(in) :: valid(:)
    integer, intent(in) :: first, last
    integer, allocatable :: runs(:, :)
    integer, allocatable :: starts(:), ends(:)
    logical, allocatable :: is_valid(:)
    integer :: n
    is_valid = [.false., valid(first:last), .false.]
    starts = pack([(n, n=first, last)], .not. is_valid(:size(is_valid) - 2) .and. is_valid(2:size(is_valid) - 1))
    ends = pack([(n, n=first, last)], is_valid(2:size(is_valid) - 1) .and. .not. is_valid(3:))
    runs = transpose(reshape([starts, ends], [size(starts), 2]))
  end function runs_of

end module bw_samples

module bw_samples
  !! Samples of one motion at several sensors, at even or uneven times. Time is counted in steps from the first sample.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: keep_sensors, place_of, span_of, valid_runs

  type, public :: samples_type
    integer :: count = 0                     !! N
    real(dp) :: step = 1                     !! s; of uneven times the median
    real(dp), allocatable :: place(:)        !! times of the samples, ascending from 0, (N); unallocated: 0, 1, 2, …
    integer, allocatable :: row(:)           !! numbers of the recorded samples, ascending from 1; unallocated: all were recorded
    real(dp), allocatable :: value(:, :)     !! (N or more, S)
    logical, allocatable :: left_out(:)      !! sensors without which lines are found, (S); unallocated: none
    logical, allocatable :: valid(:)         !! the samples of all other sensors are valid, (N); unallocated: all are
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
  end subroutine keep_sensors

  pure function valid_runs(samples, first, last) result(runs)
    !! First and last sample of each run of valid samples between two samples, (2, runs).
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: first, last
    integer, allocatable :: runs(:, :)
    integer, allocatable :: starts(:), ends(:)
    logical, allocatable :: is_valid(:)
    integer :: n
    if (.not. allocated(samples%valid)) then
      runs = reshape([first, last], [2, 1])
      return
    end if
    is_valid = [.false., samples%valid(first:last), .false.]
    starts = pack([(n, n=first, last)], .not. is_valid(:size(is_valid) - 2) .and. is_valid(2:size(is_valid) - 1))
    ends = pack([(n, n=first, last)], is_valid(2:size(is_valid) - 1) .and. .not. is_valid(3:))
    runs = transpose(reshape([starts, ends], [size(starts), 2]))
  end function valid_runs

end module bw_samples

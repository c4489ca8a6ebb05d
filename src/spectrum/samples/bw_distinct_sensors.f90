module bw_distinct_sensors
  !! Sensors without information of their own: constant ones, those left out, and multiples of another sensor. Noise is estimated
  !! and lines are found without them; otherwise their samples would be counted twice, or their lack of noise taken for accuracy.
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_samples, only: keep_sensors, samples_type
  implicit none (type, external)
  private
  public :: find_distinct, keep_distinct

  real(dp), parameter :: rounding = 4*epsilon(1.0_dp)  !! relative, of a sample

  type, public :: distinct_type
    !! The samples of sensor s: factor(s) times those of sensor kept(place(s)); if place(s) is 0, all are the number
    !! constant(s), which is `missing` if the sensor was left out.
    integer, allocatable :: kept(:)            !! sensors with samples of their own, ascending
    integer, allocatable :: place(:)           !! (S)
    real(dp), allocatable :: factor(:), constant(:)  !! (S)
  end type distinct_type

contains

  pure function find_distinct(samples) result(distinct)
    !! Compare all sensors. If all are constant, the first one is kept.
    type(samples_type), intent(in) :: samples
    type(distinct_type) :: distinct
    integer :: highest(size(samples%value, 2)), s, j
    logical :: is_constant(size(samples%value, 2)), left_out(size(samples%value, 2))
    left_out = .false.
    if (allocated(samples%left_out)) left_out = samples%left_out
    distinct%kept = [integer ::]
    associate (value => samples%value(:samples%count, :))
      highest = [(maxloc(abs(value(:, s)), dim=1), s=1, size(highest))]  ! one sensor at a time: a record may fill the memory
      is_constant = [(all_are(value(:, s), value(1, s)), s=1, size(highest))]
      is_constant = is_constant .or. left_out
      if (all(is_constant)) is_constant(findloc(left_out, .false., dim=1)) = .false.
      distinct%place = 0*highest
      distinct%factor = [(1.0_dp, s=1, size(highest))]
      distinct%constant = merge(missing, value(1, :), left_out)
      do s = 1, size(highest)
        if (is_constant(s)) cycle
        do j = 1, size(distinct%kept)
          associate (other => value(:, distinct%kept(j)))
            if (.not. abs(other(highest(s))) > 0) cycle
            distinct%factor(s) = value(highest(s), s)/other(highest(s))
            if (is_multiple(value(:, s), other, distinct%factor(s))) exit
          end associate
        end do
        distinct%place(s) = j
        if (j <= size(distinct%kept)) cycle
        distinct%factor(s) = 1
        distinct%kept = [distinct%kept, s]
      end do
    end associate
  end function find_distinct

  pure logical function all_are(value, number)
    !! Whether all numbers are equal to this one.
    real(dp), intent(in) :: value(:), number
    integer :: n
    all_are = .false.
    do n = 1, size(value)
      if (abs(value(n) - number) > 0) return
    end do
    all_are = .true.
  end function all_are

  pure logical function is_multiple(value, other, factor)
    !! Whether numbers are others times a factor, to within rounding.
    real(dp), intent(in) :: value(:), other(:), factor
    integer :: n
    is_multiple = .false.
    do n = 1, size(value)
      if (abs(value(n) - factor*other(n)) > rounding*abs(value(n))) return
    end do
    is_multiple = .true.
  end function is_multiple

  subroutine keep_distinct(distinct, samples)
    !! Remove the sensors that are constant or multiples of others.
    type(distinct_type), intent(in) :: distinct
    type(samples_type), intent(inout) :: samples
    if (size(distinct%kept) < size(distinct%place)) call keep_sensors(distinct%kept, samples)
  end subroutine keep_distinct

end module bw_distinct_sensors

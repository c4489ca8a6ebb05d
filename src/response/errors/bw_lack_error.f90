module bw_lack_error
  !! Errors of histories due to errors of the modal state (lack_type of bw_segment): known differences, due to a finite
  !! number of modes before the capture, and bounded ones. Amplitudes add to the bound; their sum at a sample is
  !! estimated as in bw_truncation_error.
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_mode_set, only: curvatures, mode_set
  use bw_mode_survey, only: mode_survey, point_sums
  use bw_projection, only: likely
  use bw_segment, only: lack_type
  use bw_truncation_error, only: no_bound, rate_likely, spread_of_samples
  implicit none (type, external)
  private
  public :: find_lack

  type, public :: lack_error
    real(dp), allocatable :: bound(:)            !! of the displacement, (points)
    real(dp), allocatable :: displacement(:)     !! estimate, (points)
    real(dp), allocatable :: rate(:)             !! estimate for velocities, or for curvatures, (points)
  end type lack_error

contains

  subroutine find_lack(lack, modes, count, survey, samples, part, times, error)
    !! Find the errors of displacements, and of velocities or curvatures, due to errors of the modal state.
    type(lack_type), intent(in) :: lack
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: count                 !! modes summed
    type(mode_survey), intent(in) :: survey      !! of these modes
    integer, intent(in) :: samples               !! number of samples
    real(dp), intent(in) :: part(:)              !! |sum of a block| over the sum of its amplitudes, (points)
    real(dp), intent(in) :: times(:)             !! velocity of a block over its root mean square, (points)
    type(lack_error), intent(out) :: error
    real(dp) :: middle(size(part)), middle_rate(size(part))
    integer :: b
    allocate (error%bound(size(part)), error%displacement(size(part)), error%rate(size(part)), source=0.0_dp)
    if (allocated(lack%rate)) call add(1.0_dp, lack%rate, lack%q)
    if (allocated(lack%rate_doubt)) call add(lack%likely, lack%rate_doubt, lack%q_doubt)
    if (lack%bounded >= count) return
    if (is_missing(lack%energy)) then
      error = unknown()
      return
    end if
    middle = 0.0_dp
    middle_rate = 0.0_dp
    do b = 1, survey%bins
      associate (bin => survey%bin(b), share => survey%at(:, b)%share)
        if (bin%last <= lack%bounded .or. bin%last > count) cycle
        middle = middle + share/bin%mean_square
        if (survey%quantity == curvatures) then
          middle_rate = middle_rate + share/bin%mean_square/(count - lack%bounded)
        else
          middle_rate = middle_rate + share/(count - lack%bounded)
        end if
      end associate
    end do
    error%bound = error%bound + sqrt(2.0_dp*lack%energy*middle)
    error%displacement = error%displacement + min(1.0_dp, likely*part)*sqrt(2.0_dp*lack%energy*middle)
    error%rate = error%rate + rate_likely*times*sqrt(lack%energy*middle_rate)
  contains
    pure type(lack_error) function unknown()
      allocate (unknown%bound(size(part)), unknown%displacement(size(part)), unknown%rate(size(part)), source=no_bound)
    end function unknown

    subroutine add(weight, rate, q)
      !! Add the effect of one of the two kinds of errors.
      real(dp), intent(in) :: weight, rate(:)
      real(dp), intent(in), optional :: q(:)
      type(mode_survey) :: own
      type(point_sums) :: sums(size(part))
      real(dp) :: none(size(rate))
      if (maxval(rate) >= no_bound .or. minval(rate) <= -no_bound) then
        error = unknown()
        return
      end if
      call own%start(survey%quantity, survey%points, survey%stretch, [count])
      none = 0.0_dp
      if (present(q)) then
        call own%add_set(modes, 1, count, q, rate)
      else
        call own%add_set(modes, 1, count, none, rate)
      end if
      sums%reach = sum(own%at(:, :own%bins)%reach, 2)
      sums%square = sum(own%at(:, :own%bins)%square, 2)
      sums%rate_square = sum(own%at(:, :own%bins)%rate_square, 2)
      error%bound = error%bound + sums%reach
      error%displacement = error%displacement + weight*min(sums%reach, likely*max(part*sums%reach, &
                                                           spread_of_samples(samples)*sqrt(0.5_dp*sums%square)))
      if (survey%quantity == curvatures) sums%rate_square = sums%square
      error%rate = error%rate + weight*rate_likely*times*sqrt(0.5_dp*sums%rate_square)
    end subroutine add
  end subroutine find_lack

end module bw_lack_error

module bw_case_octave
  !! Histories that the highest modes decide. A sum of n modes of which those from n/2 + 1 on add more than the whole sum reaches
  !! has not begun to converge: nothing of it is given.
  use bw_case_histories, only: sum_histories
  use bw_case_moments, only: sum_moments
  use bw_case_result, only: case_done, case_histories, case_motion, case_not_converged, history_errors
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: missing
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_scene, only: scene_type
  use bw_text, only: append, shortest, text_of
  implicit none (type, external)
  private
  public :: drop_undecided

contains

  subroutine drop_undecided(scene, motion, monitor, workspace, histories, errors)
    !! Put fill in the place of such histories, of the points where they are so, and say so. The modes are summed once more, and
    !! only where the estimated error exceeds the history.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout), target :: monitor  !! the histories mean nothing where it asks to stop
    type(nonuniform_sum), intent(inout) :: workspace
    type(case_histories), intent(inout) :: histories
    type(history_errors), intent(inout) :: errors          !! whose status and notes are those of the case
    type(case_histories) :: octave
    type(part_monitor) :: part                             ! how long this takes is not known
    real(dp), allocatable :: moments(:, :)
    integer :: first
    logical :: counted
    if (errors%status /= case_done .or. .not. allocated(scene%capture)) return
    first = motion%plan%count/2 + 1
    part = part_monitor(monitor, 1.0_dp, 0.0_dp)
    associate (response => histories%response)
      counted = .not. by_tolerance(scene%modes)            ! a tolerance is one of the largest displacement of all points
      if ((counted .and. any(is_doubtful(response%displacement, errors%displacement))) .or. &
          any(is_doubtful(response%velocity, errors%velocity))) then
        call sum_histories(scene, motion, part, workspace, octave, first)
        if (monitor%stop_requested()) return
        if (counted) call drop('displacement', octave%response%displacement, errors%displacement, response%displacement)
        call drop('velocity', octave%response%velocity, errors%velocity, response%velocity)
      end if
      if (any(is_doubtful(response%bending_moment, errors%bending_moment))) then
        call sum_moments(scene, motion, part, workspace, moments, first)
        if (monitor%stop_requested()) return
        call drop('bending moment', moments, errors%bending_moment, response%bending_moment)
      end if
    end associate
  contains
    subroutine drop(quantity, added, error, history)
      !! One quantity.
      character(*), intent(in) :: quantity
      real(dp), intent(in), optional :: added(:, :)        !! by the last octave, (samples, points); absent: not asked for
      real(dp), intent(in), optional :: error(:)           !! (points)
      real(dp), intent(inout), optional :: history(:, :)   !! likewise
      logical, allocatable :: lost(:)
      integer :: p
      if (.not. present(history)) return
      lost = is_doubtful(history, error)
      lost = lost .and. [(largest_magnitude(added(:, p)) > largest_magnitude(history(:, p)), p=1, size(lost))]
      if (.not. any(lost)) return
      p = findloc(lost, .true., dim=1)
      errors%status = case_not_converged
      call append(errors%notes, 'not converged: the '//quantity//' at xi = '//shortest(scene%response%points(p), 6)// &
                  others(count(lost) - 1)//' is less than what modes '//text_of(first)//' to '//text_of(motion%plan%count)// &
                  ' add to it, and is not given; more modes, or damping, let it converge')
      do p = 1, size(lost)
        if (lost(p)) history(:, p) = missing
      end do
    end subroutine drop
  end subroutine drop_undecided

  function is_doubtful(history, error) result(doubtful)
    !! The estimated error exceeds the largest value, beside what a point that does not move has of rounding, (points).
    real(dp), intent(in), optional :: history(:, :)        !! (samples, points); absent: there is none
    real(dp), intent(in), optional :: error(:)             !! (points)
    logical, allocatable :: doubtful(:)
    real(dp), parameter :: nothing = 1.0e-9_dp             ! of the largest peak
    real(dp), allocatable :: peak(:)
    integer :: p
    allocate (doubtful(0))
    if (.not. (present(history) .and. present(error))) return
    peak = [(largest_magnitude(history(:, p)), p=1, size(error))]
    doubtful = error > peak .and. error > nothing*maxval(peak) .and. maxval(peak) > 0.0_dp
  end function is_doubtful

  pure function others(count) result(words)
    !! How many more points there are of which that is said.
    integer, intent(in) :: count
    character(:), allocatable :: words
    words = ''
    if (count > 0) words = ', and at '//text_of(count)//' more of the points,'
  end function others

end module bw_case_octave

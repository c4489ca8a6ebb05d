module bw_case_octave
  !! Histories that depend on the highest modes. If modes n/2 + 1 to n contribute more than the sum of all n reaches,
  !! the sum has not begun to converge and is not given.
  use bw_case_result, only: case_done, case_histories, case_motion, case_not_converged, history_errors, octave_of
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: missing
  use bw_scene, only: scene_type
  use bw_text, only: append, shortest, text_of
  implicit none (type, external)
  private
  public :: drop_unresolved

contains

  subroutine drop_unresolved(scene, motion, histories, errors)
    !! Replace such histories by fill, at points where the estimated error also exceeds the history, and note it.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(case_histories), intent(inout) :: histories
    type(history_errors), intent(inout) :: errors          !! whose status and notes are those of the case
    integer :: points
    if (errors%status /= case_done .or. .not. allocated(scene%capture) .or. .not. allocated(histories%blocks)) return
    points = size(scene%response%points)
    associate (response => histories%response)
      if (.not. allocated(motion%plan%survey)) &                ! a tolerance is one of the largest displacement of all points
        call drop('displacement', octave_of(histories, points), errors%displacement, response%displacement)
      call drop('velocity', octave_of(histories, points, .true.), errors%velocity, response%velocity)
      call drop('bending moment', histories%octave_moment, errors%bending_moment, response%bending_moment)
    end associate
  contains
    subroutine drop(quantity, added, error, history)
      !! Check one quantity.
      character(*), intent(in) :: quantity
      real(dp), intent(in), optional :: added(:)           !! largest of the last octave, (points); absent: not requested
      real(dp), intent(in), optional :: error(:)           !! (points)
      real(dp), intent(inout), optional :: history(:, :)   !! (samples, points)
      logical, allocatable :: lost(:)
      integer :: count_of, p
      count_of = motion%timeline%segments(1)%count
      if (.not. (present(added) .and. present(history) .and. present(error))) return
      lost = is_doubtful(history, error)
      lost = lost .and. [(added(p) > largest_magnitude(history(:, p)), p=1, size(lost))]
      if (.not. any(lost)) return
      p = findloc(lost, .true., dim=1)
      errors%status = case_not_converged
      call append(errors%notes, 'not converged: the '//quantity//' at xi = '//shortest(scene%response%points(p), 6)// &
                  others(count(lost) - 1)//' is smaller than the contribution of modes '//text_of(count_of/2 + 1)//' to '// &
                  text_of(count_of)//', and is missing; try before = '//text_of(4*count_of)// &
                  ', or &damping, with which it converges')
      do p = 1, size(lost)
        if (lost(p)) history(:, p) = missing
      end do
    end subroutine drop
  end subroutine drop_unresolved

  function is_doubtful(history, error) result(doubtful)
    !! Return whether the estimated error exceeds the peak of a history and the rounding of a point at rest, (points).
    real(dp), intent(in), optional :: history(:, :)        !! (samples, points); absent: none
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
    !! Return how many more points are concerned, in words.
    integer, intent(in) :: count
    character(:), allocatable :: words
    words = ''
    if (count > 0) words = ', and at '//text_of(count)//' more of the points,'
  end function others

end module bw_case_octave

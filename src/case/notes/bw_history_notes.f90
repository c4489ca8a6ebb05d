module bw_history_notes
  !! Warnings of histories that are undersampled or inaccurate, and what would help.
  use bw_case_result, only: history_errors
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: is_missing
  use bw_modes_par, only: by_tolerance
  use bw_response, only: response_type
  use bw_sampled_peak, only: hidden_share, known_samples
  use bw_scene, only: converges_in_run, scene_type
  use bw_text, only: append, shortest, string, text_of
  implicit none (type, external)
  private
  public :: note_history_errors

  real(dp), parameter, public :: negligible = 0.01_dp
    !! of a history's peak: errors or aliases below it need no warning
  real(dp), parameter :: nothing = 1.0e-9_dp       !! of the largest peak: the root does not move

contains

  subroutine note_history_errors(scene, response, errors, leading_notes, notes)
    !! Note histories with large errors, and what would reduce them.
    type(scene_type), intent(in) :: scene
    type(response_type), intent(in) :: response
    type(history_errors), intent(in) :: errors     !! unallocated component: no estimate
    type(string), allocatable, intent(inout) :: leading_notes(:)    !! for errors that exceed the history
    type(string), allocatable, intent(inout) :: notes(:)       !! for others
    integer :: n
    n = response%finite_samples
    if (n == 0) return
    call note_sampling(scene, response, errors, notes)
    if (allocated(errors%displacement)) call note_error('displacement', response%displacement(:n, :), errors%displacement)
    if (allocated(errors%velocity)) call note_error('velocity', response%velocity(:n, :), errors%velocity)
    if (allocated(errors%bending_moment)) call note_error('bending moment', response%bending_moment(:n, :), errors%bending_moment)
    if (allocated(errors%acceleration)) call note_error('acceleration', response%acceleration(:n, :), errors%acceleration)
    if (allocated(errors%shear_force)) call note_error('shear force', response%shear_force(:n, :), errors%shear_force)
  contains
    subroutine note_error(quantity, histories, error)
      !! Note the point with the largest error over its own peak.
      character(*), intent(in) :: quantity
      real(dp), intent(in) :: histories(:, :), error(:)
      real(dp), parameter :: most = 1.0e6_dp       ! avoids overflow
      real(dp) :: part(size(error)), peak(size(error))
      character(:), allocatable :: text
      integer :: p
      peak = [(largest_magnitude(histories(:, p)), p=1, size(error))]
      part = 0.0_dp
      if (maxval(peak) == 0.0_dp) return             ! no motion yet
      where (error > negligible*peak .and. error > nothing*maxval(peak)) part = error/max(peak, error/most)
      p = maxloc(part, dim=1)
      if (part(p) == 0.0_dp) return
      text = 'error of the '//quantity//': at xi = '//shortest(scene%response%points(p), 6)//' it may be off by '// &
        part_words(part(p))//others(count(part > 0.0_dp) - 1)//'; '//remedy(scene, quantity)
      if (part(p) > 1.0_dp) then
        call append(leading_notes, text)
      else
        call append(notes, text)
      end if
    end subroutine note_error
  end subroutine note_history_errors

  subroutine note_sampling(scene, response, errors, notes)
    !! Warn of peaks between samples, for each quantity at the point with the largest estimate, and say how many times
    !! the samples would show them to 1 %: once samples resolve the motion, the loss falls with the square of their
    !! distance. Silent if the estimated error is larger.
    type(scene_type), intent(in) :: scene
    type(response_type), intent(in) :: response
    type(history_errors), intent(in) :: errors     !! unallocated component: no estimate
    type(string), allocatable, intent(inout) :: notes(:)
    character(:), allocatable :: words
    real(dp) :: worst
    integer :: times
    words = ''
    worst = 0.0_dp
    call add_words('displacement', response%displacement, errors%displacement)
    if (allocated(response%bending_moment)) call add_words('bending moment', response%bending_moment, errors%bending_moment)
    if (allocated(response%shear_force)) call add_words('shear force', response%shear_force, errors%shear_force)
    if (allocated(response%velocity)) call add_words('velocity', response%velocity, errors%velocity)
    if (allocated(response%acceleration)) call add_words('acceleration', response%acceleration, errors%acceleration)
    if (words == '') return
    times = 2**ceiling(0.5_dp*log(worst/negligible)/log(2.0_dp))
    call append(notes, 'sampling: peaks may lie between samples, and be larger than the largest sample: '//words(3:)// &
                '; try '//text_of(times)//' times as many samples')
  contains
    subroutine add_words(quantity, histories, error)
      character(*), intent(in) :: quantity
      real(dp), intent(in) :: histories(:, :)      !! (samples, points)
      real(dp), intent(in), optional :: error(:)   !! (points)
      real(dp), dimension(size(histories, 2)) :: hidden, peak
      integer :: n, p
      do p = 1, size(hidden)
        n = known_samples(histories(:, p))
        peak(p) = largest_magnitude(histories(:n, p))
        hidden(p) = hidden_share(histories(:n, p))
      end do
      where (is_missing(hidden) .or. .not. peak > nothing*maxval(peak)) hidden = 0.0_dp
      if (present(error)) where (error > hidden*peak) hidden = 0.0_dp
      p = maxloc(hidden, dim=1)
      if (hidden(p) <= negligible) return
      worst = max(worst, hidden(p))
      words = words//', the '//quantity//' at xi = '//shortest(scene%response%points(p), 6)//' by about '// &
        shortest(100.0_dp*hidden(p), 2)//' %'
    end subroutine add_words
  end subroutine note_sampling

  pure function remedy(scene, quantity) result(words)
    !! Return what would reduce the error of a history, in words. Velocities and bending moments inside the beam
    !! converge with the square root of the number of modes (docs/method/errors.md), unless modes are damped.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: quantity
    character(:), allocatable :: words
    if (allocated(scene%recontact)) then
      words = 'contacts amplify every error, and a shorter duration has fewer of them'
    else if (quantity == 'displacement' .or. allocated(scene%damping) .or. converges_in_run(scene)) then
      words = 'more modes reduce it: a smaller tolerance, as '//shortest(0.1_dp*scene%modes%tolerance, 2)
      if (.not. by_tolerance(scene%modes)) words = 'more modes reduce it: larger counts, as before = '// &
        shortest(2.0_dp*scene%modes%before, 15)
    else
      words = 'before = '//shortest(10.0_dp*scene%modes%before, 15)
      if (by_tolerance(scene%modes)) words = 'tolerance = '//shortest(0.03_dp*scene%modes%tolerance, 1)
      words = 'ten times as many modes ('//words//') leave about a third of it, and &damping far less'
    end if
  end function remedy

  pure function others(count) result(words)
    !! Return how many more points are concerned, in words.
    integer, intent(in) :: count
    character(:), allocatable :: words
    words = ''
    if (count > 0) words = ', and at '//text_of(count)//' more of the points by more than 1 %'
  end function others

  pure function part_words(part) result(words)
    !! Return a fraction of a history's peak, in words.
    real(dp), intent(in) :: part
    character(:), allocatable :: words
    words = shortest(100.0_dp*part, 2)//' % of its largest value'
    if (part > 1.0_dp) words = 'more than its largest value'
  end function part_words

end module bw_history_notes

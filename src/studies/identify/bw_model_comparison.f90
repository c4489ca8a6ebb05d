module bw_model_comparison
  !! The lines of records beside the modes of their beams: assignment and misfit.
  use bw_measured_state, only: measured_state, state_modes, vague_deviation
  use bw_fit_problem, only: fit_problem, problem_of
  use bw_fit_search, only: estimate_model_error, misfit_of, misfit_type, misfit_chance
  use bw_identify_par, only: identify_par
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_result_lines, only: result_lines
  implicit none (type, external)
  private
  public :: compare_case, match_lines

  type, public :: compared_lines
    !! The lines of one case with their modes; missing where a line is no mode.
    integer, allocatable :: mode(:)              !! 0: none, (lines)
    character(24), allocatable :: why_none(:)    !! why a line can hardly be a mode of any beam; empty: it may be, (lines)
    real(dp), allocatable :: frequency(:)        !! of the mode with the line's damping [rad/s], (lines)
    real(dp), allocatable :: decay(:)            !! of the mode [1/s], (lines)
    real(dp), allocatable :: frequency_misfit(:) !! measured − computed over half the interval, (lines)
    real(dp), allocatable :: decay_misfit(:)     !! likewise; missing if the modes are undamped, (lines)
    real(dp), allocatable :: shape(:, :)         !! of the mode along the beam, (places, lines)
    complex(dp), allocatable :: response(:, :)   !! modelled, if a hammer's force is measured; (frequencies, sensors)
  end type compared_lines

contains

  subroutine match_lines(state, misfit)
    !! Assign the lines of one state without unknowns.
    type(measured_state), intent(inout) :: state
    type(misfit_type), intent(out) :: misfit
    type(fit_problem) :: problem
    type(identify_par) :: none(0)
    real(dp), allocatable :: residuals(:)
    real(dp) :: penalty
    logical :: changed
    problem = problem_of([state], none)
    if (size(state%lines%frequency) == 0) return
    call problem%match(0.0_dp, penalty, changed)
    problem%scatter = 0
    call problem%minimise(residuals, .false.)
    misfit = misfit_of(problem, residuals)
    if (misfit%tail < misfit_chance) call estimate_model_error(problem)
    misfit%scatter = problem%scatter
    state = problem%states(1)
  end subroutine match_lines

  subroutine compare_case(measured, state, values, places, compared)
    !! Compare lines with the modes that they are taken for.
    type(result_lines), intent(in) :: measured
    type(measured_state), intent(inout) :: state     !! with its assignment
    real(dp), intent(in) :: values(:)            !! of the unknowns
    integer, intent(in) :: places                !! along the beam, for shapes; 0: none
    type(compared_lines), intent(out) :: compared
    type(state_modes) :: modes
    real(dp), allocatable :: shape(:, :)
    integer, allocatable :: line(:)
    real(dp) :: square
    integer :: i, k, n
    n = size(state%mode_of)
    compared%mode = state%mode_of
    allocate (compared%frequency(n), compared%decay(n), compared%frequency_misfit(n), compared%decay_misfit(n), source=missing)
    allocate (compared%shape(places, n), source=missing)
    compared%why_none = [(why_none(state, k), k=1, n)]
    line = pack([(k, k=1, n)], state%mode_of > 0)
    call state%modes_at(values, state%mode_of(line), modes)
    if (.not. modes%found) return
    do i = 1, size(line)
      k = line(i)
      square = modes%frequency(i)**2 - measured%lines%decay(k)**2
      if (square >= 0) compared%frequency(k) = sqrt(square)
      compared%decay(k) = modes%decay(i)
      if (square >= 0 .and. measured%error(k) > 0) compared%frequency_misfit(k) = &
        (measured%angular_frequency(k) - compared%frequency(k))/measured%error(k)
      if (measured%decay_error(k) > 0 .and. modes%decay(i) > 0) compared%decay_misfit(k) = &
        (measured%lines%decay(k) - modes%decay(i))/measured%decay_error(k)
    end do
    if (places == 0 .or. .not. allocated(state%lines%points)) return
    call state%shapes_along(values, state%mode_of(line), [(real(i, dp)/(places - 1), i=0, places - 1)], shape)
    if (allocated(shape)) compared%shape(:, line) = transpose(shape)
  end subroutine compare_case

  pure function why_none(state, k) result(words)
    !! Say why a line can hardly be a mode of any beam.
    type(measured_state), intent(in) :: state
    integer, intent(in) :: k
    character(24) :: words
    words = ''
    if (state%chance(k) > 0.5_dp) words = 'a tone, or a multiple'
    if (state%lines%deviation(k) > vague_deviation*state%lines%frequency(k)) words = 'not known to 5 %'
    if (state%is_harmonic(k)) words = 'a harmonic'
  end function why_none

end module bw_model_comparison

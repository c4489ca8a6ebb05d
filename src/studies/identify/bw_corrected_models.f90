module bw_corrected_models
  !! Corrections of a model that does not explain its lines: each missing effect or doubtful input is put into the
  !! scenes, with unknowns of its own if it has a size, and everything is fitted again.
  use bw_beam_fit, only: fit_beam
  use bw_measured_state, only: measured_state
  use bw_fit_problem, only: fit_problem, position_in, problem_of, value_at
  use bw_fit_search, only: fit_type
  use bw_identification, only: identification
  use bw_identify_par, only: identify_par
  use bw_kinds, only: dp
  use bw_correction_candidates, only: correction_candidate, list_candidates, apply_correction
  use bw_scene_states, only: all_unknowns, measured_scene, states_of
  implicit none (type, external)
  private
  public :: find_corrections

  type, public :: corrected_model
    !! An added effect, and how well the model fits with it.
    character(:), allocatable :: effect          !! in words
    type(identify_par), allocatable :: unknowns(:)   !! that it added
    real(dp), allocatable :: values(:)           !! their fitted values
    type(fit_type) :: fit
  end type corrected_model

  real(dp), parameter, public :: accepted_share = 0.9_dp  !! chosen: of τ; a correction that leaves more does not help

contains

  subroutine find_corrections(measured, found, corrections)
    !! Try all possible corrections, sorted by remaining misfit.
    type(measured_scene), intent(in) :: measured(:)
    type(identification), intent(in) :: found    !! without corrections
    type(corrected_model), allocatable, intent(out) :: corrections(:)
    type(correction_candidate), allocatable :: candidates(:)
    type(measured_scene), allocatable :: variant(:)
    type(corrected_model) :: corrected
    logical :: possible
    integer :: i
    allocate (corrections(0))
    call list_candidates(measured(1)%scene, candidates)
    do i = 1, size(candidates)
      call apply_correction(candidates(i), measured, variant, possible)
      if (.not. possible) cycle
      call fit_again(candidates(i), variant, found, corrected)
      if (corrected%fit%freedom > 0) call insert(corrections, corrected)       ! else nothing tests it
    end do
  end subroutine find_corrections

  subroutine fit_again(candidate, variant, found, corrected)
    !! Fit with an effect; lines that are no modes without it stay so.
    type(correction_candidate), intent(in) :: candidate
    type(measured_scene), intent(in) :: variant(:)
    type(identification), intent(in) :: found    !! without the effect
    type(corrected_model), intent(out) :: corrected
    type(fit_problem) :: problem
    type(measured_state), allocatable :: states(:)
    type(fit_type), allocatable :: others(:)
    real(dp), allocatable :: near(:)             ! start: the model without the effect, at its fit
    logical :: thorough
    integer :: i, n, last
    call states_of(variant, states)
    n = 0
    do i = 1, size(states)
      states(i)%is_harmonic = found%fit%mode_of(n + 1:n + size(states(i)%is_harmonic)) == 0
      n = n + size(states(i)%is_harmonic)
    end do
    problem = problem_of(states, all_unknowns(variant))
    thorough = count(candidate%unknown /= '') > 1 .and. .not. allocated(variant(1)%scene%stiffening)     ! then modes are expensive
    last = size(variant(1)%scene%unknowns)
    n = last - count(candidate%unknown /= '')
    near = position_in(problem%unknowns(n + 1:last), candidate%neutral(:last - n))
    if (allocated(found%fit%v)) near = [found%fit%v(:n), near, found%fit%v(n + 1:)]
    call fit_beam(problem, 0.0_dp, thorough, corrected%fit, others, near)
    corrected%effect = trim(candidate%effect)
    corrected%unknowns = problem%unknowns(n + 1:last)
    corrected%values = value_at(corrected%unknowns, corrected%fit%v(n + 1:last))
  end subroutine fit_again

  pure subroutine insert(corrections, corrected)
    !! Insert a correction in its place.
    type(corrected_model), allocatable, intent(inout) :: corrections(:)
    type(corrected_model), intent(in) :: corrected
    type(corrected_model), allocatable :: more(:)
    integer :: i, n
    n = size(corrections)
    allocate (more(n + 1))
    do i = n, 1, -1
      if (.not. is_better(corrected, corrections(i))) exit
      more(i + 1) = corrections(i)
    end do
    more(:i) = corrections(:i)
    more(i + 1) = corrected
    call move_alloc(more, corrections)
  end subroutine insert

  pure logical function is_better(one, other)
    !! Order corrections by τ, then by the number of unknowns, then by amplitudes, then by χ².
    type(corrected_model), intent(in) :: one, other
    is_better = one%fit%scatter < other%fit%scatter
    if (abs(one%fit%scatter - other%fit%scatter) > 0.0_dp) return
    is_better = size(one%values) < size(other%values)
    if (size(one%values) /= size(other%values)) return
    is_better = one%fit%amplitude_error < other%fit%amplitude_error
    if (abs(one%fit%amplitude_error - other%fit%amplitude_error) > 0.0_dp) return
    is_better = one%fit%chi_squared < other%fit%chi_squared
  end function is_better

end module bw_corrected_models

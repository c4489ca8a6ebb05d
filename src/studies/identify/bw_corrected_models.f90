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
    integer, private :: candidate = 0
  end type corrected_model

  real(dp), parameter, public :: accepted_share = 0.9_dp  !! chosen: of τ; a correction that leaves more does not help

contains

  subroutine find_corrections(measured, found, corrections)
    !! Try all possible corrections, sorted by remaining misfit. If none explains the lines, try pairs of the best ones
    !! too; a pair counts only if it reduces the misfit more than either.
    type(measured_scene), intent(in) :: measured(:)
    type(identification), intent(in) :: found    !! without corrections
    type(corrected_model), allocatable, intent(out) :: corrections(:)
    integer, parameter :: most_combined = 4
    type(correction_candidate), allocatable :: candidates(:)
    type(measured_scene), allocatable :: variant(:)
    type(corrected_model), allocatable :: single(:)
    type(corrected_model) :: corrected
    logical :: possible
    integer :: i, j
    allocate (corrections(0))
    call list_candidates(measured(1)%scene, candidates)
    do i = 1, size(candidates)
      call apply_correction(candidates(i), measured, variant, possible)
      if (.not. possible) cycle
      call fit_again(candidates(i), variant, found, found%fit, measured, corrected)
      corrected%candidate = i
      if (corrected%fit%freedom > 0) call insert(corrections, corrected)       ! else nothing tests it
    end do
    single = corrections(:min(size(corrections), most_combined))
    if (any(single%fit%scatter <= 0.0_dp)) return
    do i = 1, size(single)
      do j = i + 1, size(single)
        if (single(j)%fit%scatter > accepted_share*found%fit%scatter) exit
        call fit_two(measured, candidates(single(i)%candidate), candidates(single(j)%candidate), single(i), found, corrected, &
                     possible)
        if (.not. possible .or. corrected%fit%freedom < 1) cycle
        if (corrected%fit%scatter <= accepted_share*single(i)%fit%scatter) call insert(corrections, corrected)
      end do
    end do
  end subroutine find_corrections

  subroutine fit_two(measured, first, second, one, found, corrected, possible)
    !! Fit two effects, starting from the fit with the first.
    type(measured_scene), intent(in) :: measured(:)
    type(correction_candidate), intent(in) :: first, second
    type(corrected_model), intent(in) :: one           !! with the first
    type(identification), intent(in) :: found
    type(corrected_model), intent(out) :: corrected
    logical, intent(out) :: possible
    type(correction_candidate), allocatable :: further(:)
    type(measured_scene), allocatable :: variant(:), both(:)
    integer :: k
    call apply_correction(first, measured, variant, possible)
    call list_candidates(variant(1)%scene, further)            ! a body has another number after one was added
    k = findloc(further%effect, second%effect, dim=1)
    possible = possible .and. k > 0
    if (possible) call apply_correction(further(k), variant, both, possible)
    if (.not. possible) return
    call fit_again(further(k), both, found, one%fit, measured, corrected)
    corrected%effect = one%effect//' and '//corrected%effect
  end subroutine fit_two

  subroutine fit_again(candidate, variant, found, before, measured, corrected)
    !! Fit with one more effect; lines that are no modes without effects stay so.
    type(correction_candidate), intent(in) :: candidate
    type(measured_scene), intent(in) :: variant(:)
    type(identification), intent(in) :: found
    type(fit_type), intent(in) :: before         !! without this effect
    type(measured_scene), intent(in) :: measured(:)            !! without effects
    type(corrected_model), intent(out) :: corrected
    type(fit_problem) :: problem
    type(measured_state), allocatable :: states(:)
    type(fit_type), allocatable :: others(:)
    real(dp), allocatable :: near(:)             ! start: the model without the effect, at its fit
    integer, allocatable :: added(:)             ! unknowns of all effects, the last of the first scene
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
    if (allocated(before%v)) near = [before%v(:n), near, before%v(n + 1:)]
    call fit_beam(problem, 0.0_dp, thorough, corrected%fit, others, near)
    added = [(i, i=size(measured(1)%scene%unknowns) + 1, last)]
    corrected%effect = trim(candidate%effect)
    corrected%unknowns = problem%unknowns(added)
    corrected%values = value_at(corrected%unknowns, corrected%fit%v(added))
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

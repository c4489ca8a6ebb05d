module bw_absent_mends
  !! Which effect that the model leaves out, or which number that it gives, would mend its misfit: each is put into the scenes,
  !! with unknowns of its own where it has a size, and everything is fitted again.
  use bw_beam_fit, only: fit_beam
  use bw_beam_state, only: beam_state
  use bw_fit_problem, only: fit_problem, position_in, problem_of, value_at
  use bw_fit_search, only: fit_type
  use bw_identification, only: identification
  use bw_identify_par, only: identify_par
  use bw_kinds, only: dp
  use bw_mend_candidates, only: candidate_type, list_candidates, put_in
  use bw_scene_states, only: all_unknowns, measured_scene, states_of
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: find_mends

  type, public :: mend_type
    !! An effect that was put in, and how well the model fits with it.
    character(:), allocatable :: effect          !! in words
    type(identify_par), allocatable :: unknowns(:)   !! that came with it
    real(dp), allocatable :: values(:)           !! what they were fitted to
    type(fit_type) :: fit
  end type mend_type

contains

  subroutine find_mends(measured, found, mends)
    !! All effects that can be put in, those that leave least first.
    type(measured_scene), intent(in) :: measured(:)
    type(identification), intent(in) :: found    !! without them
    type(mend_type), allocatable, intent(out) :: mends(:)
    type(candidate_type), allocatable :: candidates(:)
    type(measured_scene), allocatable :: variant(:)
    type(mend_type) :: mend
    logical :: possible
    integer :: i
    allocate (mends(0))
    call list_candidates(measured(1)%scene, candidates)
    do i = 1, size(candidates)
      call put_in(candidates(i), measured, variant, possible)
      if (.not. possible) cycle
      call fit_again(candidates(i), variant, found, mend)
      if (mend%fit%freedom > 0) call insert(mends, mend)       ! else nothing tests it
    end do
  end subroutine find_mends

  subroutine fit_again(candidate, variant, found, mend)
    !! The fit with an effect; lines that are no modes without it are none with it.
    type(candidate_type), intent(in) :: candidate
    type(measured_scene), intent(in) :: variant(:)
    type(identification), intent(in) :: found
    type(mend_type), intent(out) :: mend
    type(fit_problem) :: problem
    type(beam_state), allocatable :: states(:)
    type(fit_type), allocatable :: others(:)
    real(dp), allocatable :: near(:)             ! where it is the model without the effect, at its fit
    integer, allocatable :: added(:)             ! its unknowns, the last ones of the first scene
    logical :: thorough
    integer :: i, n
    call states_of(variant, states)
    n = 0
    do i = 1, size(states)
      states(i)%is_harmonic = found%fit%mode_of(n + 1:n + size(states(i)%is_harmonic)) == 0
      n = n + size(states(i)%is_harmonic)
    end do
    problem = problem_of(states, all_unknowns(variant))
    thorough = count(candidate%unknown /= '') > 1 .and. .not. allocated(variant(1)%scene%stiffening)     ! there modes are dear
    n = size(variant(1)%scene%unknowns) - count(candidate%unknown /= '')
    added = [(i, i=n + 1, size(variant(1)%scene%unknowns))]
    near = [candidate%neutral(:size(added))]
    if (allocated(found%values)) near = [found%values(:n), near, found%values(n + 1:)]
    near = position_in(problem%unknowns, near)
    call fit_beam(problem, 0.0_dp, thorough, mend%fit, others, near)
    mend%effect = trim(candidate%effect)
    mend%unknowns = problem%unknowns(added)
    mend%values = value_at(mend%unknowns, mend%fit%v(added))
  end subroutine fit_again

  pure subroutine insert(mends, mend)
    !! One more, in its place.
    type(mend_type), allocatable, intent(inout) :: mends(:)
    type(mend_type), intent(in) :: mend
    type(mend_type), allocatable :: more(:)
    integer :: i, n
    n = size(mends)
    allocate (more(n + 1))
    do i = n, 1, -1
      if (.not. mends_more(mend, mends(i))) exit
      more(i + 1) = mends(i)
    end do
    more(:i) = mends(:i)
    more(i + 1) = mend
    call move_alloc(more, mends)
  end subroutine insert

  pure logical function mends_more(one, other)
    !! The one that leaves less: by τ, then by what it took of unknowns, then by χ².
    type(mend_type), intent(in) :: one, other
    mends_more = one%fit%scatter < other%fit%scatter
    if (abs(one%fit%scatter - other%fit%scatter) > 0.0_dp) return
    mends_more = size(one%values) < size(other%values)
    if (size(one%values) /= size(other%values)) return
    mends_more = one%fit%chi_squared < other%fit%chi_squared
  end function mends_more

end module bw_absent_mends

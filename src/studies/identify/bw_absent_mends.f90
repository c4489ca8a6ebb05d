module bw_absent_mends
  !! Which effect that the model leaves out would mend its misfit: each is put into the scenes, with an unknown of its own
  !! where its size is not known, and everything is fitted again.
  use bw_beam_fit, only: fit_beam
  use bw_beam_par, only: second_moment_of
  use bw_beam_state, only: beam_state
  use bw_error, only: error_type
  use bw_fit_problem, only: fit_problem, problem_of, value_at
  use bw_fit_search, only: fit_type
  use bw_identification, only: identification
  use bw_kinds, only: dp
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  use bw_scene_resolved, only: resolved_text
  use bw_scene_states, only: measured_scene, states_of
  use bw_scene_variant, only: has_group, with_group
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: find_mends

  character, parameter :: nl = new_line('a')

  type, public :: mend_type
    !! An effect that was put in, and how well the model fits with it.
    character(:), allocatable :: effect          !! in words
    character(:), allocatable :: parameter, unit !! the unknown that came with it; '' without one
    real(dp) :: value = 0.0_dp                   !! what it was fitted to
    type(fit_type) :: fit
  end type mend_type

  type :: candidate_type
    character(32) :: effect = ''                 !! in words
    character(16) :: group = ''                  !! that is put in
    character(32) :: name = ''                   !! its number that is unknown; '' where it has none
    character(64) :: values = ''                 !! its other names
    real(dp) :: first = 0.0_dp, last = 0.0_dp    !! range of the unknown
  end type candidate_type

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
      call insert(mends, mend)
    end do
  end subroutine find_mends

  subroutine list_candidates(scene, candidates)
    !! The effects that the scene does not have, with ranges about what would matter to its beam.
    type(scene_type), intent(in) :: scene
    type(candidate_type), allocatable, intent(out) :: candidates(:)
    real(dp) :: turning, force, mass, length
    length = scene%beam%length
    turning = scene%beam%youngs_modulus*real(second_moment_of(scene%beam%beam_piece), dp)/length
    mass = scene%beam%density*scene%beam%area*length
    if (allocated(scene%beam%pieces)) then
      turning = scene%beam%pieces(1)%youngs_modulus*real(second_moment_of(scene%beam%pieces(1)), dp)/length
      mass = sum(scene%beam%pieces%density*scene%beam%pieces%area*scene%beam%pieces%length)
    end if
    force = turning/length**2
    candidates = [candidate_type('shear and rotary inertia', 'shear'), &
                  candidate_type('a root that turns', 'support', 'rotational_stiffness', '', 0.1_dp*turning, 1.0e5_dp*turning), &
                  candidate_type('a root that gives way', 'support', 'stiffness', '', force, 1.0e7_dp*force), &
                  candidate_type('a mass at the tip', 'body', 'mass', 'position = 1', 0.0_dp, mass), &
                  candidate_type('a body''s rotary inertia', 'body(1)', 'rotary_inertia', '', 0.0_dp, 0.1_dp*mass*length**2), &
                  candidate_type('tension by rotation', 'stiffening')]
    if (.not. allocated(scene%rotation)) candidates = candidates(:5)
  end subroutine list_candidates

  subroutine put_in(candidate, measured, variant, possible)
    !! The scenes with an effect, where none of them has it already and all can.
    type(candidate_type), intent(in) :: candidate
    type(measured_scene), intent(in) :: measured(:)
    type(measured_scene), allocatable, intent(out) :: variant(:)
    logical, intent(out) :: possible
    character(:), allocatable :: text
    type(error_type), allocatable :: error
    integer :: i
    allocate (variant(size(measured)))
    do i = 1, size(measured)
      text = resolved_text(measured(i)%scene)
      if (candidate%group == 'body(1)') then
        possible = allocated(measured(i)%scene%bodies)
        if (possible) possible = measured(i)%scene%bodies(1)%rotary_inertia == 0.0_dp
      else
        possible = .not. has_group(text, trim(candidate%group))
        if (candidate%name == '') text = with_group(text, trim(candidate%group), trim(candidate%values))
        if (candidate%name /= '') text = text//'&'//trim(candidate%group)//nl//'  '//trim(candidate%values)//nl//'  '// &
          trim(candidate%name)//' = '//text_of(candidate%last)//nl//'/'//nl
      end if
      if (.not. possible) return
      if (i == 1 .and. candidate%name /= '') text = text//"&identify"//nl//"  parameter = '"//trim(candidate%group)//'%'// &
        trim(candidate%name)//"'"//nl//'  first = '//text_of(candidate%first)//nl//'  last = '//text_of(candidate%last)//nl//'/'//nl
      call read_scene_text(text, measured(i)%scene%file, variant(i)%scene, error)
      possible = .not. allocated(error)
      if (.not. possible) return
      variant(i)%lines = measured(i)%lines
    end do
  end subroutine put_in

  subroutine fit_again(candidate, variant, found, mend)
    !! The fit with an effect; lines that are no modes without it are none with it.
    type(candidate_type), intent(in) :: candidate
    type(measured_scene), intent(in) :: variant(:)
    type(identification), intent(in) :: found
    type(mend_type), intent(out) :: mend
    type(fit_problem) :: problem
    type(beam_state), allocatable :: states(:)
    type(fit_type), allocatable :: others(:)
    integer :: i, n
    call states_of(variant, states)
    n = 0
    do i = 1, size(states)
      states(i)%is_harmonic = found%fit%mode_of(n + 1:n + size(states(i)%is_harmonic)) == 0
      n = n + size(states(i)%is_harmonic)
    end do
    problem = problem_of(states, variant(1)%scene%unknowns)
    call fit_beam(problem, 0.0_dp, .false., mend%fit, others)
    mend%effect = trim(candidate%effect)
    mend%parameter = ''
    mend%unit = ''
    if (candidate%name == '') return
    associate (unknown => problem%unknowns(size(problem%unknowns)))
      mend%parameter = unknown%parameter
      mend%unit = unknown%unit
      mend%value = value_at(unknown, mend%fit%v(size(mend%fit%v)))
    end associate
  end subroutine fit_again

  pure subroutine insert(mends, mend)
    !! One more, in the order of what is left: of τ, then of χ².
    type(mend_type), allocatable, intent(inout) :: mends(:)
    type(mend_type), intent(in) :: mend
    type(mend_type), allocatable :: more(:)
    integer :: i, n
    n = size(mends)
    allocate (more(n + 1))
    do i = n, 1, -1
      if (mends(i)%fit%scatter < mend%fit%scatter .or. (mends(i)%fit%scatter == mend%fit%scatter .and. &
                                                       mends(i)%fit%chi_squared <= mend%fit%chi_squared)) exit
      more(i + 1) = mends(i)
    end do
    more(:i) = mends(:i)
    more(i + 1) = mend
    call move_alloc(more, mends)
  end subroutine insert

end module bw_absent_mends

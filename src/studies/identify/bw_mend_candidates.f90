module bw_mend_candidates
  !! What may be wrong with a model that does not explain its lines: effects that it leaves out, and numbers that it gives. Each
  !! is put into the scenes as text, with unknowns of its own where it has a size.
  use bw_beam_par, only: second_moment_of
  use bw_error, only: error_type
  use bw_input_values, only: group_values, positions_of
  use bw_kinds, only: dp
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  use bw_scene_resolved, only: resolved_text
  use bw_scene_states, only: measured_scene
  use bw_scene_variant, only: has_group, with_value
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: list_candidates, put_in

  character, parameter :: nl = new_line('a')

  type, public :: candidate_type
    character(40) :: effect = ''                 !! in words
    character(16) :: group = ''                  !! that it is about
    logical :: added = .false.                   !! the group comes new, else the scene has it
    character(16) :: place = ''                  !! the group as unknowns name it
    character(40) :: name = ''                   !! other name of the group that is set,
    character(16) :: value = ''                  !! and to what
    character(24) :: unknown(2) = ''             !! its numbers that are unknown
    real(dp) :: first(2) = 0.0_dp, last(2) = 0.0_dp    !! their ranges
    real(dp) :: neutral(2) = 0.0_dp              !! with these it is the model that it mends
  end type candidate_type

contains

  subroutine list_candidates(scene, candidates)
    !! All for a scene, with ranges about what would matter to its beam.
    type(scene_type), intent(in) :: scene
    type(candidate_type), allocatable, intent(out) :: candidates(:)
    real(dp) :: turning, mass, length
    integer, allocatable :: bodies(:)
    length = scene%beam%length
    turning = scene%beam%youngs_modulus*real(second_moment_of(scene%beam%beam_piece), dp)/length
    mass = scene%beam%density*scene%beam%area*length
    if (allocated(scene%beam%pieces)) then
      turning = scene%beam%pieces(1)%youngs_modulus*real(second_moment_of(scene%beam%pieces(1)), dp)/length
      mass = sum(scene%beam%pieces%density*scene%beam%pieces%area*scene%beam%pieces%length)
    end if
    bodies = positions_of(scene%groups, 'body')
    allocate (candidates(0))
    call add(candidate_type('shear and rotary inertia', 'shear', .true.))
    call add(one_unknown('a root that turns', 'support', 'rotational_stiffness', 0.1_dp*turning, 1.0e5_dp*turning))
    call add(one_unknown('a root that gives way', 'support', 'stiffness', turning/length**2, 1.0e7_dp*turning/length**2))
    call add(a_body('a mass at the tip', size(bodies) + 1, 'position', '1', mass))
    call add(a_body('a mass on the beam', size(bodies) + 1, '', '', mass))
    candidates(size(candidates))%unknown(2) = 'position'
    candidates(size(candidates))%first(2) = 0.02_dp
    candidates(size(candidates))%last(2) = 1.0_dp
    candidates(size(candidates))%neutral(2) = 1.0_dp
    call add(candidate_type('tension by rotation', 'stiffening', .true.))
    if (allocated(scene%rotation)) call add(candidate_type('rotation in the other plane', 'rotation', name='plane', &
                                                           value=merge("'out'", "'in' ", scene%rotation%plane == 'in')))
    call add_given(scene%groups, 'support', 'rotational_stiffness', 'another stiffness of the turning root', 1.0e4_dp)
    call add_given(scene%groups, 'support', 'stiffness', 'another stiffness of the root', 1.0e4_dp)
    call add_given(scene%groups, 'rotation', 'angular_velocity', 'another speed', 3.0_dp)
    call add_given(scene%groups, 'body', 'mass', 'another mass of the first body', 30.0_dp)
    if (size(bodies) > 0) then
      call add(candidate_type('another place of the first body', 'body', place='body(1)', unknown=['position', '        '], &
                              first=[0.02_dp, 0.0_dp], last=[1.0_dp, 0.0_dp], &
                              neutral=given_number(scene%groups(bodies(1)), 'position')))
      call add(candidate_type('a body''s rotary inertia', 'body', place='body(1)', unknown=['rotary_inertia', '              '], &
                              last=[0.1_dp*mass*length**2, 0.0_dp], &
                              neutral=given_number(scene%groups(bodies(1)), 'rotary_inertia')))
    end if
    call add_given(scene%groups, 'beam', 'youngs_modulus', 'another modulus', 3.0_dp)
  contains
    subroutine add(candidate)
      type(candidate_type), intent(in) :: candidate
      candidates = [candidates, candidate]
    end subroutine add

    type(candidate_type) function one_unknown(effect, group, name, first, last) result(candidate)
      character(*), intent(in) :: effect, group, name
      real(dp), intent(in) :: first, last
      integer, allocatable :: places(:)
      candidate%effect = effect
      candidate%group = group
      candidate%place = group
      places = positions_of(scene%groups, group)
      candidate%added = size(places) == 0
      candidate%unknown(1) = name
      candidate%first(1) = first
      candidate%last(1) = last
      candidate%neutral(1) = last
      if (candidate%added) return
      if (scene%groups(places(1))%known(name)) candidate%effect = ''    ! it is there
    end function one_unknown

    function given_number(group, name) result(neutral)
      !! What a group says of a name, if anything, for the first of two unknowns.
      type(group_values), intent(in) :: group
      character(*), intent(in) :: name
      real(dp) :: neutral(2)
      neutral = 0.0_dp
      if (group%known(name)) neutral(1) = group%number(name)
    end function given_number

    subroutine add_given(groups, group, name, effect, factor)
      type(group_values), intent(in) :: groups(:)
      character(*), intent(in) :: group, name, effect
      real(dp), intent(in) :: factor             !! by which the range is larger and smaller
      integer, allocatable :: places(:)
      character(len(candidates%place)) :: place
      real(dp) :: given
      places = positions_of(groups, group)
      if (size(places) == 0) return
      if (.not. groups(places(1))%known(name)) return
      given = abs(groups(places(1))%number(name))
      if (.not. given > 0.0_dp) return
      place = group
      if (group == 'body') place = 'body(1)'
      call add(candidate_type(effect, group, place=place, unknown=[character(24) :: name, ''], &
                              first=[given/factor, 0.0_dp], last=[given*factor, 0.0_dp], neutral=[given, 0.0_dp]))
    end subroutine add_given
  end subroutine list_candidates

  pure type(candidate_type) function a_body(effect, number, name, value, mass) result(candidate)
    !! One more body, of an unknown mass up to that of the beam.
    character(*), intent(in) :: effect, name, value
    integer, intent(in) :: number
    real(dp), intent(in) :: mass
    candidate%effect = effect
    candidate%group = 'body'
    candidate%added = .true.
    candidate%place = 'body('//text_of(number)//')'
    candidate%name = name
    candidate%value = value
    candidate%unknown(1) = 'mass'
    candidate%last(1) = mass
  end function a_body

  subroutine put_in(candidate, measured, variant, possible)
    !! The scenes with it, where all of them can have it.
    type(candidate_type), intent(in) :: candidate
    type(measured_scene), intent(in) :: measured(:)
    type(measured_scene), allocatable, intent(out) :: variant(:)
    logical, intent(out) :: possible
    character(:), allocatable :: text
    type(error_type), allocatable :: error
    integer :: i
    possible = candidate%effect /= ''
    if (.not. possible) return
    allocate (variant(size(measured)))
    do i = 1, size(measured)
      text = resolved_text(measured(i)%scene)
      if (candidate%group == 'body') possible = candidate%added .or. has_group(text, 'body')
      if (candidate%group /= 'body') possible = candidate%added .neqv. has_group(text, trim(candidate%group))
      if (.not. possible) return
      text = changed(candidate, text)
      if (i == 1) text = text//unknowns_text(candidate)
      call read_scene_text(text, measured(i)%scene%file, variant(i)%scene, error)
      possible = .not. allocated(error)
      if (.not. possible) return
      variant(i)%lines = measured(i)%lines
    end do
  end subroutine put_in

  function changed(candidate, text) result(edited)
    !! A scene with the group or the values. What a number is does not matter where it is unknown, but that it is there.
    type(candidate_type), intent(in) :: candidate
    character(*), intent(in) :: text
    character(:), allocatable :: edited, values
    integer :: i
    if (candidate%added) then
      values = ''
      if (candidate%name /= '') values = '  '//trim(candidate%name)//' = '//trim(candidate%value)//nl
      do i = 1, size(candidate%unknown)
        if (candidate%unknown(i) /= '') values = values//'  '//trim(candidate%unknown(i))//' = '//text_of(candidate%last(i))//nl
      end do
      edited = text
      if (candidate%place == 'body(2)') edited = first_body_numbered(text)
      edited = edited//'&'//trim(candidate%group)//nl//values//'/'//nl
    else
      edited = text
      if (candidate%name /= '') edited = with_value(text, trim(candidate%group), trim(candidate%name), trim(candidate%value))
      do i = 1, size(candidate%unknown)
        if (candidate%unknown(i) /= '') edited = with_value(edited, trim(candidate%group), trim(candidate%unknown(i)), &
                                                            text_of(candidate%last(i)))
      end do
    end if
  end function changed

  pure function first_body_numbered(text) result(edited)
    !! The only body is the first of two from here on.
    character(*), intent(in) :: text
    character(:), allocatable :: edited
    character(*), parameter :: only = '''body%', first = '''body(1)%'
    integer :: i
    edited = text
    do
      i = index(edited, only)
      if (i == 0) return
      edited = edited(:i - 1)//first//edited(i + len(only):)
    end do
  end function first_body_numbered

  pure function unknowns_text(candidate) result(text)
    !! Its `&identify` groups.
    type(candidate_type), intent(in) :: candidate
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(candidate%unknown)
      if (candidate%unknown(i) == '') cycle
      text = text//'&identify'//nl//"  parameter = '"//trim(candidate%place)//'%'//trim(candidate%unknown(i))//"'"//nl// &
        '  first = '//text_of(candidate%first(i))//nl//'  last = '//text_of(candidate%last(i))//nl//'/'//nl
    end do
  end function unknowns_text

end module bw_mend_candidates

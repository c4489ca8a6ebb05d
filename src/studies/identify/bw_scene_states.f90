module bw_scene_states
  !! The states of a beam from scenes and their lines. The unknowns of the first scene are shared: a name that another
  !! scene sets is the same unknown there. Unknowns of a further scene's own belong to it alone.
  use bw_measured_state, only: measured_state, state_lines, state_of
  use bw_identify_par, only: identify_par
  use bw_input_values, only: positions_of
  use bw_monitor, only: monitor_type
  use bw_scene, only: scene_type
  use bw_scene_messages, only: message_list
  use bw_scene_unknowns, only: find_unknown
  implicit none (type, external)
  private
  public :: all_unknowns, states_of, unknowns_in

  type, public :: measured_scene
    !! A scene with the lines measured in its state.
    type(scene_type) :: scene                    !! without sweeps; scenes of one name are repeats
    type(state_lines) :: lines
    class(monitor_type), pointer :: monitor => null()    !! fits are invalid once it asks to stop
  end type measured_scene

contains

  subroutine states_of(measured, states)
    !! Make one state for each scene.
    type(measured_scene), intent(in) :: measured(:)      !! the first has the `&identify` groups
    type(measured_state), allocatable, intent(out) :: states(:)
    integer :: i
    allocate (states(size(measured)))
    do i = 1, size(measured)
      states(i) = state_of(measured(i)%scene, unknowns_in(measured, i), measured(i)%lines)
      states(i)%monitor => measured(i)%monitor
    end do
  end subroutine states_of

  function all_unknowns(measured) result(unknowns)
    !! Return the unknowns of the first scene, then those of each further scene, called `name (scene)`.
    type(measured_scene), intent(in) :: measured(:)      !! repeats of a scene one after another
    type(identify_par), allocatable :: unknowns(:)
    integer :: i, j, n, pass
    do pass = 1, 2                               ! the first pass counts: array constructors of such types leak in gfortran 12
      n = 0
      do i = 1, size(measured)
        if (is_repeat(measured, i)) cycle
        do j = 1, size(measured(i)%scene%unknowns)
          n = n + 1
          if (pass == 1) cycle
          unknowns(n) = measured(i)%scene%unknowns(j)
          if (i > 1) unknowns(n)%parameter = unknowns(n)%parameter//' ('//measured(i)%scene%name//')'
        end do
      end do
      if (pass == 1) allocate (unknowns(n))
    end do
  end function all_unknowns

  pure logical function is_repeat(measured, i)
    !! Return whether this is another case of the previous scene.
    type(measured_scene), intent(in) :: measured(:)
    integer, intent(in) :: i
    is_repeat = .false.
    if (i > 1) is_repeat = measured(i)%scene%name == measured(i - 1)%scene%name
  end function is_repeat

  function unknowns_in(measured, i) result(unknowns)
    !! Return all unknowns by their names in a scene; of group 0 if it lacks them.
    type(measured_scene), intent(in) :: measured(:)
    integer, intent(in) :: i                     !! its index
    type(identify_par), allocatable :: unknowns(:)
    integer :: j, k, shared
    unknowns = all_unknowns(measured)
    shared = size(measured(1)%scene%unknowns)
    unknowns(shared + 1:)%group = 0
    if (measured(i)%scene%name == measured(1)%scene%name) return
    call find_shared(measured(1)%scene, measured(i)%scene, unknowns)
    do j = 1, size(measured(i)%scene%unknowns)
      associate (own => measured(i)%scene%unknowns(j))
        do k = 1, shared
          if (unknowns(k)%group == own%group .and. unknowns(k)%value == own%value .and. unknowns(k)%element == own%element) &
            unknowns(k)%group = 0
        end do
        do k = shared + 1, size(unknowns)
          if (unknowns(k)%parameter == own%parameter//' ('//measured(i)%scene%name//')') unknowns(k)%group = own%group
        end do
      end associate
    end do
  end function unknowns_in

  subroutine find_shared(first, scene, unknowns)
    !! Find the unknowns of the first scene in another.
    type(scene_type), intent(in) :: first, scene
    type(identify_par), intent(inout) :: unknowns(:)     !! the first ones are those of the first scene
    type(scene_type) :: here                     !! a copy, as the search may change it
    type(message_list) :: messages               !! an absent name is no error
    integer, allocatable :: places(:)
    integer :: i
    places = positions_of(first%groups, 'identify')
    here%groups = scene%groups
    do i = 1, size(places)
      call find_unknown(first%groups(places(i)), here%groups, unknowns(i), messages)
      unknowns(i)%start = first%unknowns(i)%start
      if (unknowns(i)%group == 0) cycle
      if (.not. scene%groups(unknowns(i)%group)%values(unknowns(i)%value)%given) unknowns(i)%group = 0
    end do
  end subroutine find_shared

end module bw_scene_states

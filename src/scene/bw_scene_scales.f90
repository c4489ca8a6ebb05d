module bw_scene_scales
  !! Whether what a scene asks for can be computed in double precision. Everything inside is computed in the beam's own units: its
  !! length l, its mass and the time l²/h (bw_beam_units). Where these lie far inside the range of numbers, and so does every input
  !! in these units, products of a few of them are numbers too, and no formula has to ask.
  use bw_beam_par, only: area_of, beam_mass, beam_par, beam_piece, piece_mass, pieces_of_beam, second_moment_of, sections_of_beam
  use bw_constants, only: qp_pi
  use bw_input_name, only: has_unit, in_range, is_simulated, place_of
  use bw_input_table, only: group_table, name_table
  use bw_input_values, only: input_value, position_of
  use bw_kinds, only: dp, qp
  use bw_scene, only: changes_shapes, scene_type
  use bw_scene_messages, only: message_list
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: check_scales, own_size

  real(qp), parameter :: unit_reach = 1.0e140_qp    !! the beam's own units are so many SI units at most, or one over it at least
  real(qp), parameter :: reach = 1.0e60_qp          !! likewise inputs in these units; products of five are still numbers
  real(qp), parameter :: finest = 1.0e15_qp         !! parts of the beam's length that a place in double precision tells apart
  real(qp), parameter :: told_apart = 1.0e30_qp     !! what the 32 digits of extended precision still hold of a piece beside another
  real(qp), parameter :: longest_phase = 1.0e18_qp  !! rad: what 32 digits leave of it is right to 1e-13

  type :: own_units
    !! Of a beam, SI.
    real(qp) :: length = 1.0_qp       !! l
    real(qp) :: mass = 1.0_qp         !! m_i
    real(qp) :: time = 1.0_qp         !! l²/h
  end type own_units

contains

  pure subroutine check_scales(scene, messages)
    !! Report the numbers of a case that are out of reach, at their lines.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    type(own_units) :: own
    integer :: before, g, v
    if (position_of(scene%groups, 'beam') == 0) return
    before = messages%count
    call check_beam(scene, own, messages)
    if (messages%count > before) return
    do g = 1, size(scene%groups)
      associate (group => scene%groups(g))
        if (.not. (is_simulated(group_table(group%row)) .or. group%group == 'response')) cycle
        do v = 1, size(group%values)
          if (group%values(v)%known .and. has_unit(name_table(group%values(v)%row)) .and. .not. is_free(scene, group%values(v))) &
            call check_input(group%values(v), group%line, own, messages)
        end do
      end associate
    end do
    if (allocated(scene%impact)) call check_energy(scene, messages)
    if (allocated(scene%response)) call check_phase(scene, own, messages)
  end subroutine check_scales

  pure logical function is_free(scene, value)
    !! Nothing is computed with it: motions are proportional to the velocity of the mass, shapes are looked at anywhere, and closed
    !! forms know any mass.
    type(scene_type), intent(in) :: scene
    type(input_value), intent(in) :: value
    is_free = value%name == 'approach_velocity' .or. value%name == 'points'
    if (value%name == 'mass' .or. value%name == 'mass_ratio') is_free = .not. changes_shapes(scene)
  end function is_free

  pure real(dp) function own_size(unit, beam) result(size)
    !! How much SI a unit of the table of names is for a beam, that of a moment over an angle EI/l.
    character(*), intent(in) :: unit             !! as UDUNITS writes it
    type(beam_par), intent(in) :: beam
    size = real(unit_of(trim(unit), own_units_of(beam)), dp)
  end function own_size

  pure type(own_units) function own_units_of(beam) result(own)
    !! The units of a beam of which nothing is 0.
    type(beam_par), intent(in) :: beam
    type(beam_piece), allocatable :: pieces(:)
    pieces = pieces_of_beam(beam)
    own%length = sum(real(pieces%length, qp))
    own%mass = beam_mass(beam)
    own%time = sqrt(own%mass*own%length**3/(pieces(1)%youngs_modulus*second_moment_of(pieces(1))))
  end function own_units_of

  pure subroutine check_beam(scene, own, messages)
    !! The beam's own units, and its pieces in them.
    type(scene_type), intent(in) :: scene
    type(own_units), intent(out) :: own
    type(message_list), intent(inout) :: messages
    type(beam_piece), allocatable :: pieces(:)
    real(qp), allocatable :: stiffness(:), mass(:)  ! EI and ρA
    integer :: line
    pieces = sections_of_beam(scene%beam)
    stiffness = pieces%youngs_modulus*second_moment_of(pieces)
    mass = piece_mass(pieces)/pieces%length
    own = own_units_of(scene%beam)
    line = scene%groups(position_of(scene%groups, 'beam'))%line
    call check([own%length], unit_reach, 'the length of the beam in m', line, messages)
    call check([own%mass], unit_reach, 'the mass of the beam in kg', line, messages)
    call check([own%time], unit_reach, 'the characteristic time sqrt(m l^3/(EI)) in s', line, messages)
    call check([stiffness(1)/own%length], unit_reach, 'EI/l in N m', line, messages)
    call check(pieces%length/own%length, finest, 'the length of a piece over that of the beam', line, messages)
    call check(mass/(own%mass/own%length), told_apart, 'the mass per length of a piece over that of the beam', line, messages)
    call check(stiffness/stiffness(1), told_apart, 'the bending stiffness of a piece over that of the first', line, messages)
    if (scene%beam%is_lumped) return
    call check(second_moment_of(pieces)/area_of(pieces)/own%length**2, reach, 'I/(A l^2)', line, messages)
  end subroutine check_beam

  pure subroutine check(values, limit, what, line, messages)
    !! Numbers of the beam are within a limit.
    real(qp), intent(in) :: values(:), limit
    character(*), intent(in) :: what
    integer, intent(in) :: line
    type(message_list), intent(inout) :: messages
    integer :: i
    i = findloc(is_within(values, limit), .false., dim=1)
    if (i > 0) call messages%add(line, '&beam', what//' is '//two_digits(values(i))//'; accepted: '// &
                                  two_digits(1.0_qp/limit)//' to '//two_digits(limit))
  end subroutine check

  pure subroutine check_input(value, line, own, messages)
    !! A number is within reach in the beam's own units. A spring that is stiffer is rigid to the last digit (bw_scene_pieces).
    type(input_value), intent(in) :: value
    integer, intent(in) :: line                   !! of its group, for what is derived from others
    type(own_units), intent(in) :: own
    type(message_list), intent(inout) :: messages
    real(qp) :: unit, limit
    integer :: i
    associate (row => name_table(value%row))
      unit = unit_of(trim(row%unit), own)
      limit = merge(finest, reach, row%name == 'position')
      do i = 1, size(value%numbers)
        if (is_within(value%numbers(i)/unit, limit)) cycle
        if (any(row%unit == ['N m-1    ', 'N m rad-1']) .and. value%numbers(i) > unit) cycle
        call messages%add(merge(value%lines(i), line, value%lines(i) > 0), place_of(row), 'is '// &
                          two_digits(real(value%numbers(i), qp))//', out of range for this beam; accepted: '// &
                          repeat('0, or ', merge(1, 0, in_range(row%range, 0.0_dp)))// &
                          two_digits(unit/limit)//' to '//two_digits(min(unit*limit, real(row%range%high, qp))))
      end do
    end associate
  end subroutine check_input

  elemental logical function is_within(value, limit)
    !! Zero, or neither too large nor too small.
    real(qp), intent(in) :: value, limit
    real(qp), parameter :: told = 1.06_qp         ! limits are told in two digits, and what is told is accepted
    is_within = value == 0.0_qp .or. (abs(value) <= told*limit .and. abs(value) >= 1.0_qp/(told*limit))
  end function is_within

  pure function two_digits(value) result(text)
    !! Two digits of a number that may be beyond the range of doubles.
    real(qp), intent(in) :: value
    character(:), allocatable :: text
    text = shortest(real(sign(min(max(abs(value), real(tiny(1.0_dp), qp)), real(huge(1.0_dp), qp)), value), dp), 2)
  end function two_digits

  pure real(qp) function unit_of(unit, own) result(size)
    !! How much SI a unit of the table of names is in the beam's own units: `N m rad-1` is m l²/t².
    character(*), intent(in) :: unit             !! as UDUNITS writes it
    type(own_units), intent(in) :: own
    real(qp) :: base
    integer :: first, last, letters, power
    size = 1.0_qp
    first = 1
    do while (first <= len(unit))
      last = first - 1 + index(unit(first:)//' ', ' ') - 1
      letters = scan(unit(first:last)//'1', '0123456789-') - 1
      select case (unit(first:first + letters - 1))
      case ('m'); base = own%length
      case ('kg'); base = own%mass
      case ('s'); base = own%time
      case ('Hz'); base = 1.0_qp/own%time
      case ('N'); base = own%mass*own%length/own%time**2
      case ('Pa'); base = own%mass/own%length/own%time**2
      case default; base = 1.0_qp                 ! a radian, or a number
      end select
      power = 1
      if (first + letters <= last .and. letters > 0) read (unit(first + letters:last), *) power
      size = size*base**power
      first = last + 2
    end do
  end function unit_of

  pure subroutine check_energy(scene, messages)
    !! The kinetic energy of the mass is a number.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    real(qp), parameter :: most = 1.0e308_qp      ! J
    if (scene%impact%mass*real(scene%impact%approach_velocity, qp)**2 <= most) return
    call messages%add(scene%groups(position_of(scene%groups, 'impact'))%line, '&impact', 'the kinetic energy of the mass is '// &
                      'too large for double precision; accepted: up to '//two_digits(most)//' J')
  end subroutine check_energy

  pure subroutine check_phase(scene, own, messages)
    !! The phase of the highest mode at the end of the record has digits.
    type(scene_type), intent(in) :: scene
    type(own_units), intent(in) :: own
    type(message_list), intent(inout) :: messages
    type(beam_piece), allocatable :: pieces(:)
    real(qp) :: highest                           ! mode of a beam as fast as its fastest piece, rad/s
    pieces = sections_of_beam(scene%beam)
    highest = sqrt(maxval(pieces%youngs_modulus*second_moment_of(pieces)*pieces%length/piece_mass(pieces)))/own%length**2 &
      *(qp_pi*max(scene%modes%before, scene%modes%after))**2
    if (highest*scene%response%duration <= longest_phase) return
    call messages%add(scene%groups(position_of(scene%groups, 'response'))%line_of('duration'), 'response%duration', &
                      'is so long that the phase of the highest mode is lost; accepted: up to '// &
                      two_digits(longest_phase/highest)//' s')
  end subroutine check_phase

end module bw_scene_scales

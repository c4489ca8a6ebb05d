module bw_scene_scales
  !! Checks that a scene can be computed in double precision. All computations use the beam's own units: its length l, its
  !! mass and the time l²/h (bw_beam_units). These units, and every input in them, are kept far inside the range of
  !! double precision. Then products of a few of them are in range too, and no formula needs a check.
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

  real(qp), parameter :: unit_reach = 1.0e140_qp    !! limit of the beam's own units in SI, and of their inverse
  real(qp), parameter :: reach = 1.0e60_qp          !! limit of inputs in these units; products of five are in range
  real(qp), parameter :: finest = 1.0e15_qp         !! 1/resolution of a place along the beam in double precision
  real(qp), parameter :: resolvable = 1.0e30_qp     !! ratio of two pieces that the 32 digits of extended precision still resolve
  real(qp), parameter :: longest_phase = 1.0e18_qp  !! rad; with 32 digits the remainder mod 2π is accurate to 1e-13

  type :: own_units
    !! The units of a beam, in SI.
    real(qp) :: length = 1.0_qp       !! l
    real(qp) :: mass = 1.0_qp         !! m_i
    real(qp) :: time = 1.0_qp         !! l²/h
  end type own_units

contains

  pure subroutine check_scales(scene, messages)
    !! Report the numbers of a case that are out of range, at their lines.
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
    !! Return whether a value needs no check: motions are proportional to the velocity of the mass, shapes can be evaluated
    !! anywhere, and closed forms hold for any mass.
    type(scene_type), intent(in) :: scene
    type(input_value), intent(in) :: value
    is_free = value%name == 'approach_velocity' .or. value%name == 'points'
    if (value%name == 'mass' .or. value%name == 'mass_ratio') is_free = .not. changes_shapes(scene)
  end function is_free

  pure real(dp) function own_size(unit, beam) result(size)
    !! Convert a unit of the table of names to SI for a beam: a moment per angle is EI/l.
    character(*), intent(in) :: unit             !! as UDUNITS writes it
    type(beam_par), intent(in) :: beam
    size = real(unit_of(trim(unit), own_units_of(beam)), dp)
  end function own_size

  pure type(own_units) function own_units_of(beam) result(own)
    !! Return the units of a beam whose values are not 0.
    type(beam_par), intent(in) :: beam
    type(beam_piece), allocatable :: pieces(:)
    pieces = pieces_of_beam(beam)
    own%length = sum(real(pieces%length, qp))
    own%mass = beam_mass(beam)
    own%time = sqrt(own%mass*own%length**3/(pieces(1)%youngs_modulus*second_moment_of(pieces(1))))
  end function own_units_of

  pure subroutine check_beam(scene, own, messages)
    !! Check the beam's own units, and its pieces in them.
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
    call check(mass/(own%mass/own%length), resolvable, 'the mass per length of a piece over that of the beam', line, messages)
    call check(stiffness/stiffness(1), resolvable, 'the bending stiffness of a piece over that of the first', line, messages)
    if (scene%beam%is_lumped) return
    call check(second_moment_of(pieces)/area_of(pieces)/own%length**2, reach, 'I/(A l^2)', line, messages)
  end subroutine check_beam

  pure subroutine check(values, limit, what, line, messages)
    !! Check that numbers of the beam are within a limit.
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
    !! Check that a number is in range in the beam's own units. A stiffer spring is rigid to the last digit (bw_scene_pieces).
    type(input_value), intent(in) :: value
    integer, intent(in) :: line                   !! of its group, for derived values
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
    !! Return whether a number is zero or within a limit and its inverse.
    real(qp), intent(in) :: value, limit
    real(qp), parameter :: printed = 1.06_qp         ! limits are printed with two digits, and the printed value is accepted
    is_within = value == 0.0_qp .or. (abs(value) <= printed*limit .and. abs(value) >= 1.0_qp/(printed*limit))
  end function is_within

  pure function two_digits(value) result(text)
    !! Return two digits of a number that may be beyond the range of double precision.
    real(qp), intent(in) :: value
    character(:), allocatable :: text
    text = shortest(real(sign(min(max(abs(value), real(tiny(1.0_dp), qp)), real(huge(1.0_dp), qp)), value), dp), 2)
  end function two_digits

  pure real(qp) function unit_of(unit, own) result(size)
    !! Return the value in SI of a unit of the table of names in the beam's own units: `N m rad-1` is m l²/t².
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
    !! Check that the kinetic energy of the mass does not overflow.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    real(qp), parameter :: most = 1.0e308_qp      ! J
    if (scene%impact%mass*real(scene%impact%approach_velocity, qp)**2 <= most) return
    call messages%add(scene%groups(position_of(scene%groups, 'impact'))%line, '&impact', 'the kinetic energy of the mass is '// &
                      'too large for double precision; accepted: up to '//two_digits(most)//' J')
  end subroutine check_energy

  pure subroutine check_phase(scene, own, messages)
    !! Check that the phase of the highest mode at the end of the record has significant digits.
    type(scene_type), intent(in) :: scene
    type(own_units), intent(in) :: own
    type(message_list), intent(inout) :: messages
    type(beam_piece), allocatable :: pieces(:)
    real(qp) :: highest                           ! highest mode of a uniform beam as fast as the fastest piece, rad/s
    pieces = sections_of_beam(scene%beam)
    highest = sqrt(maxval(pieces%youngs_modulus*second_moment_of(pieces)*pieces%length/piece_mass(pieces)))/own%length**2 &
      *(qp_pi*max(scene%modes%before, scene%modes%after))**2
    if (highest*scene%response%duration <= longest_phase) return
    call messages%add(scene%groups(position_of(scene%groups, 'response'))%line_of('duration'), 'response%duration', &
                      'is so long that the phase of the highest mode is lost; accepted: up to '// &
                      two_digits(longest_phase/highest)//' s')
  end subroutine check_phase

end module bw_scene_scales

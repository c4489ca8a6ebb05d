module bw_piece_beam
  !! A beam of uniform pieces with bodies and springs at their ends, without tension.
  !!
  !! Lengths are in l, so those of the pieces add to 1; stiffness, mass and time are in any consistent units, such as EI
  !! and ρA of a uniform beam and l²/h. Numbers are double-double: a quotient of two inputs is as accurate as the
  !! inputs, also for phases at the end of a long history.
  use bw_double_double, only: dd, to_dd, operator(+), operator(-), operator(/), operator(==)
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: arm_of, attach, cut_at, cut_all, holds_tip, is_held, joint_at, joint_position, junctions_of, &
    modes_at_rest, root_power, side_of_tip, operator(==)

  real(dp), parameter :: same_place = 8.0_dp*epsilon(1.0_dp)

  real(dp), parameter, public :: rigid = 1.0e60_dp   !! a spring, in EI/l³ or EI/l, that is rigid to rounding

  type, public :: uniform_piece
    type(dd) :: length = dd(1.0_dp)
    type(dd) :: stiffness = dd(1.0_dp)        !! B = EI
    type(dd) :: mass = dd(1.0_dp)             !! m = ρA, per length
    type(dd) :: compliance                    !! s = 1/(κGA); 0: no shear
    type(dd) :: rotary                        !! ρI, per length; 0: no rotary inertia
  end type uniform_piece

  type, public :: beam_joint
    !! A joint: the attachments at the outer end of a piece. Springs act in the rotating frame.
    type(dd) :: mass
    type(dd) :: inertia                       !! J
    type(dd) :: stiffness                     !! k_v, against deflection
    type(dd) :: turning_stiffness             !! k_θ, against rotation of the section
  end type beam_joint

  type, public :: beam_root
    !! The support at ξ = 0. A rigid one has no spring.
    logical :: holds_deflection = .true.
    logical :: holds_turning = .true.
    type(dd) :: stiffness                     !! k_v, unless deflection is held
    type(dd) :: turning_stiffness             !! k_θ, unless rotation is held
    logical :: on_hub = .false.               !! on a hub that is free to rotate
    type(dd) :: hub_inertia                   !! J of the hub about its axis
    type(dd) :: hub_radius                    !! R, distance of ξ = 0 from the axis
  end type beam_root

  type, public :: piece_beam
    !! The beam. A component added here, or to a part, belongs in the comparison of its type as well.
    type(uniform_piece), allocatable :: piece(:)   !! from the root outwards, (n)
    type(beam_joint), allocatable :: joint(:)      !! at the outer ends of the pieces; the last is the tip, (n)
    type(beam_root) :: root
    type(dd) :: spin_squared                       !! Ω², square of the angular velocity of the rotating frame
    logical :: in_plane = .false.                  !! the beam bends in the plane of rotation
  contains
    procedure, private :: same_beam
    generic :: operator(==) => same_beam
  end type piece_beam

  interface operator(==)
    module procedure :: same_piece, same_joint, same_root
  end interface

contains

  pure logical function same_beam(self, other) result(same)
    !! Compare two beams bitwise: equal beams have the same modes.
    class(piece_beam), intent(in) :: self
    type(piece_beam), intent(in) :: other
    same = size(self%piece) == size(other%piece) .and. (self%in_plane .eqv. other%in_plane)
    if (same) same = self%root == other%root .and. self%spin_squared == other%spin_squared &
      .and. all(self%piece == other%piece) .and. all(self%joint == other%joint)
  end function same_beam

  elemental logical function same_piece(a, b) result(same)
    type(uniform_piece), intent(in) :: a, b
    same = a%length == b%length .and. a%stiffness == b%stiffness .and. a%mass == b%mass &
      .and. a%compliance == b%compliance .and. a%rotary == b%rotary
  end function same_piece

  elemental logical function same_joint(a, b) result(same)
    type(beam_joint), intent(in) :: a, b
    same = a%mass == b%mass .and. a%inertia == b%inertia .and. a%stiffness == b%stiffness &
      .and. a%turning_stiffness == b%turning_stiffness
  end function same_joint

  elemental logical function same_root(a, b) result(same)
    type(beam_root), intent(in) :: a, b
    same = (a%holds_deflection .eqv. b%holds_deflection) .and. (a%holds_turning .eqv. b%holds_turning) &
      .and. a%stiffness == b%stiffness .and. a%turning_stiffness == b%turning_stiffness &
      .and. (a%on_hub .eqv. b%on_hub) .and. a%hub_inertia == b%hub_inertia .and. a%hub_radius == b%hub_radius
  end function same_root

  pure type(dd) function joint_position(beam, i) result(position)
    !! Return the end of piece i, from the root.
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: i                       !! 0 … n; 0 is the root
    integer :: j
    do j = 1, i
      position = position + beam%piece(j)%length
    end do
  end function joint_position

  pure integer function joint_at(beam, xi) result(joint)
    !! Return the joint at a place, 0 for the root; −1 if there is none.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: xi
    type(dd) :: gap
    gap = to_dd(-xi)
    do joint = 0, size(beam%piece)
      if (joint > 0) gap = gap + beam%piece(joint)%length
      if (abs(gap%hi) <= same_place) return
    end do
    joint = -1
  end function joint_at

  pure function junctions_of(beam) result(joints)
    !! Return the joints within the beam with attachments or a step of the section, from the root outwards.
    type(piece_beam), intent(in) :: beam
    integer, allocatable :: joints(:)
    type(uniform_piece) :: as_long
    logical :: differs(size(beam%piece))
    integer :: i
    differs = .false.
    do i = 1, size(beam%piece) - 1
      as_long = beam%piece(i + 1)
      as_long%length = beam%piece(i)%length
      differs(i) = .not. (beam%piece(i) == as_long .and. beam%joint(i) == beam_joint())
    end do
    joints = pack([(i, i=1, size(differs))], differs)
  end function junctions_of

  pure subroutine cut_at(beam, position, i)
    !! Make a joint at a position by cutting the piece there. None is cut at an existing joint, to within rounding.
    !! Later pieces keep their ends.
    type(piece_beam), intent(inout) :: beam
    type(dd), intent(in) :: position               !! from the root, 0 < position ≤ the beam's length
    integer, intent(out) :: i                      !! the joint at that position
    type(piece_beam) :: whole
    type(dd) :: before, left
    do i = 1, size(beam%piece)
      left = joint_position(beam, i) - position
      if (abs(left%hi) <= same_place) return
      if (left%hi > 0.0_dp) exit
    end do
    if (i > size(beam%piece)) then                 ! beyond the tip by rounding
      i = size(beam%piece)
      return
    end if
    before = position - joint_position(beam, i - 1)
    whole = beam
    beam%piece = [whole%piece(:i), whole%piece(i:)]
    beam%piece(i)%length = before
    beam%piece(i + 1)%length = left
    beam%joint = [whole%joint(:i - 1), beam_joint(), whole%joint(i:)]
  end subroutine cut_at

  pure subroutine attach(beam, position, body)
    !! Attach a body with springs at a position.
    type(piece_beam), intent(inout) :: beam
    type(dd), intent(in) :: position               !! see `cut_at`
    type(beam_joint), intent(in) :: body
    integer :: i
    call cut_at(beam, position, i)
    associate (joint => beam%joint(i))
      joint%mass = joint%mass + body%mass
      joint%inertia = joint%inertia + body%inertia
      joint%stiffness = joint%stiffness + body%stiffness
      joint%turning_stiffness = joint%turning_stiffness + body%turning_stiffness
    end associate
  end subroutine attach

  pure type(piece_beam) function cut_all(beam, parts) result(fine)
    !! Return the beam with every piece cut into equal parts.
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: parts(:)                !! of each piece, ≥ 1, (n)
    integer :: i, j, last
    fine = beam
    deallocate (fine%piece, fine%joint)
    allocate (fine%piece(sum(parts)), fine%joint(sum(parts)))
    last = 0
    do i = 1, size(beam%piece)
      do j = last + 1, last + parts(i)
        fine%piece(j) = beam%piece(i)
        fine%piece(j)%length = beam%piece(i)%length/to_dd(real(parts(i), dp))
      end do
      last = last + parts(i)
      fine%joint(last) = beam%joint(i)
    end do
  end function cut_all

  pure integer function root_power(root) result(power)
    !! Return the power of ξ with which shapes rise at the root.
    type(beam_root), intent(in) :: root
    power = 0
    if (root%holds_deflection) power = merge(2, 1, root%holds_turning)
  end function root_power

  pure function holds_tip(beam) result(held)
    !! Return whether deflection and rotation of the tip are rigidly held.
    type(piece_beam), intent(in) :: beam
    logical :: held(2)
    associate (tip => beam%joint(size(beam%joint)))
      held = [tip%stiffness%hi >= rigid, tip%turning_stiffness%hi >= rigid]
    end associate
  end function holds_tip

  pure logical function is_held(beam, xi)
    !! Return whether a place is an end of the beam with rigidly held deflection.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: xi
    logical :: tip(2)
    tip = holds_tip(beam)
    is_held = (xi == 0.0_dp .and. beam%root%holds_deflection) .or. (xi == 1.0_dp .and. tip(1))
  end function is_held

  pure real(dp) function arm_of(beam, xi) result(arm)
    !! Return the displacement of a place per rotation of a free hub: its distance from the axis; 0 without such a hub.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: xi
    arm = 0.0_dp
    if (beam%root%on_hub) arm = beam%root%hub_radius%hi + xi
  end function arm_of

  pure real(dp) function side_of_tip(beam, motion, moment) result(side)
    !! Return a number with the sign of the deflection at the tip or, if the tip is held, next to it.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: motion(2)              !! v and ψ of the tip
    real(dp), intent(in) :: moment                 !! M there, up to a positive factor
    logical :: held(2)
    held = holds_tip(beam)
    side = motion(1)
    if (held(1)) side = merge(moment, -motion(2), held(2))
  end function side_of_tip

  pure integer function modes_at_rest(beam) result(number)
    !! Count the modes known to have λ = 0: rigid motions without springs, not destabilised by rotary inertia.
    type(piece_beam), intent(in) :: beam
    integer :: holds
    logical :: turns
    holds = merge(1, 0, beam%root%holds_deflection .or. beam%root%stiffness%hi > 0.0_dp) &
      + count(beam%joint%stiffness%hi > 0.0_dp)
    turns = .not. (beam%root%holds_turning .or. beam%root%turning_stiffness%hi > 0.0_dp &
                   .or. any(beam%joint%turning_stiffness%hi > 0.0_dp))
    number = merge(1, 0, holds == 0)
    if (.not. turns .or. holds > 1) return
    if (beam%spin_squared%hi > 0.0_dp) then
      if (any(beam%piece%rotary%hi > 0.0_dp)) return
      if (beam%in_plane .and. any(beam%joint%inertia%hi > 0.0_dp)) return
    end if
    number = number + 1
  end function modes_at_rest

end module bw_piece_beam

module bw_scene_pieces
  !! The beam of a scene as pieces with bodies and springs at their ends, without dimensions and without its tension: lengths in
  !! l, times in l²/h, masses in m_i, so EI at the root and the mean of ρA are 1. Numbers are double-double. A tapering piece
  !! has those of its inner end, and a law of its section. Thin layers in which tension confines bending are separate pieces.
  use bw_beam_par, only: area_of, beam_mass, beam_par, beam_piece, piece_mass, second_moment_of
  use bw_beam_piece, only: mass_law, rotary_law, stiffness_law, stretch_law
  use bw_beam_units, only: beam_units
  use bw_body_par, only: body_par
  use bw_double_double, only: dd, to_dd, to_quad, operator(*), operator(+)
  use bw_kinds, only: dp, qp
  use bw_piece_beam, only: attach, beam_joint, beam_root, cut_at, joint_position, rigid, piece_beam, uniform_piece, operator(==)
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: at_start, scene_type
  use bw_shear_par, only: shear_par
  use bw_support_par, only: support_par
  use bw_tension_layers, only: cut_layers
  use bw_varying_beam, only: piece_law, soft_parts, stepped, under_tension, varying_beam, without_tension
  implicit none (type, external)
  private
  public :: in_uniform_parts, joints_of_bodies, mass_struck, pieces_of, varying_of

  type, public :: struck_beam
    !! A beam of pieces and the place of the impact.
    type(piece_beam) :: beam
    integer :: struck = 1                          !! joint at which the mass strikes, with and without it
    real(dp) :: position = 1.0_dp                  !! ξ₀ of it
    type(beam_joint) :: captured                   !! what the captured mass adds to the joint
    real(dp) :: lightness = 1.0_dp                 !! factor on all masses, below 1 if the beam bounds one on a free hub
    type(piece_law), allocatable :: section(:)     !! variation of sections along tapering pieces; unallocated: uniform
  contains
    procedure, private :: same_struck
    generic :: operator(==) => same_struck
  end type struck_beam

  type :: full_units
    !! Units of a beam in binary128.
    real(qp) :: length = 1.0_qp                    !! l, m
    real(qp) :: stiffness = 1.0_qp                 !! EI of the root piece, N m²
    real(qp) :: mass = 1.0_qp                      !! m_i, kg
  end type full_units

contains

  pure logical function same_struck(self, other) result(same)
    !! Compare two beams without taper bitwise.
    class(struck_beam), intent(in) :: self
    type(struck_beam), intent(in) :: other
    same = self%beam == other%beam .and. self%struck == other%struck .and. self%position == other%position &
      .and. self%captured == other%captured
  end function same_struck

  pure type(struck_beam) function pieces_of(scene, units, loaded, attached) result(pieces)
    !! Return the beam with all attachments of a scene. Its pieces are the same for any bodies.
    type(scene_type), intent(in) :: scene          !! without sweeps; the caller adds tension
    type(beam_units), intent(in) :: units
    logical, intent(in) :: loaded                  !! with the captured body
    logical, intent(in), optional :: attached(:)   !! which bodies are attached, (bodies); absent: those at t = 0
    type(full_units) :: full
    type(beam_joint), allocatable :: away(:)       ! bodies that are not attached
    logical, allocatable :: there(:)
    integer :: i
    there = at_start(scene)
    if (present(attached)) there = attached
    allocate (away(size(there)))
    full = full_units_of(scene%beam)
    associate (beam => pieces%beam)
      if (allocated(scene%beam%pieces)) then
        beam%piece = piece_of(scene%beam%pieces, full)
        if (allocated(scene%shear)) call add_shear(scene%beam%pieces, scene%shear, full, beam%piece)
      else
        beam%piece = [uniform_piece()]
        if (allocated(scene%shear)) call add_shear(scene%beam%beam_piece, scene%shear, full, beam%piece)
      end if
      allocate (beam%joint(size(beam%piece)))
      if (allocated(scene%support)) beam%root = root_of(scene%support, full)
      if (allocated(scene%hub)) then
        beam%root%on_hub = .true.
        beam%root%hub_inertia = to_dd(scene%hub%rotary_inertia/full%mass/full%length**2)
        beam%root%hub_radius = to_dd(scene%hub%radius/full%length)
      end if
      if (allocated(scene%rotation)) then
        associate (omega => dimensionless_speed(scene%rotation, units))
          beam%spin_squared = omega*omega
        end associate
        beam%in_plane = acts_in_plane(scene%rotation)
      end if
      if (allocated(scene%bodies)) then
        do i = 1, size(scene%bodies)
          associate (joint => joint_of(scene%bodies(i), full))
            if (.not. there(i)) away(i) = joint
            call attach_body(beam, scene%bodies(i)%position, merge_joint(joint, there(i)))
          end associate
        end do
      end if
      if (allocated(scene%tip_support)) call attach(beam, to_dd(1.0_dp), tip_of(scene%tip_support, full))
      if (allocated(scene%impact)) pieces%position = scene%impact%position
      call cut_at(beam, to_dd(pieces%position), pieces%struck)
    end associate
    if (allocated(scene%capture)) then
      pieces%captured%mass = dd(scene%impact%mass_ratio, scene%impact%mass_ratio_low)
      pieces%captured%inertia = to_dd(scene%capture%rotary_inertia/full%mass/full%length**2)
    end if
    if (allocated(scene%stiffening)) call cut_its_layers(scene, units, away, pieces)
    if (allocated(scene%beam%outer)) call find_sections(scene, pieces)
    if (loaded) then
      call attach(pieces%beam, to_dd(pieces%position), pieces%captured)
    else
      pieces%captured = beam_joint()
    end if
  end function pieces_of

  pure type(beam_joint) function merge_joint(joint, there) result(attached)
    !! Return the joint's attachments if the body is there, else none.
    type(beam_joint), intent(in) :: joint
    logical, intent(in) :: there
    if (there) attached = joint
  end function merge_joint

  pure subroutine attach_body(beam, position, body)
    !! Attach a body anywhere; at the root only its springs count.
    type(piece_beam), intent(inout) :: beam
    real(dp), intent(in) :: position               !! ξ
    type(beam_joint), intent(in) :: body
    if (position > 0.0_dp) then
      call attach(beam, to_dd(position), body)
      return
    end if
    if (.not. beam%root%holds_deflection) beam%root%stiffness = beam%root%stiffness + body%stiffness
    if (.not. beam%root%holds_turning) beam%root%turning_stiffness = beam%root%turning_stiffness + body%turning_stiffness
  end subroutine attach_body

  pure subroutine cut_its_layers(scene, units, away, pieces)
    !! Cut layers as thin as with all bodies that the beam ever carries, so that its pieces do not depend on them.
    type(scene_type), intent(in) :: scene          !! with tension
    type(beam_units), intent(in) :: units
    type(beam_joint), intent(in) :: away(:)        !! bodies that are not attached, (bodies)
    type(struck_beam), intent(inout) :: pieces     !! with the mass that it captures, not yet attached
    type(struck_beam) :: heaviest
    integer :: i
    heaviest = pieces
    do i = 1, size(away)
      call attach_body(heaviest%beam, scene%bodies(i)%position, away(i))
    end do
    call attach(heaviest%beam, to_dd(pieces%position), pieces%captured)
    if (allocated(scene%beam%outer)) call find_sections(scene, heaviest)
    call cut_layers(pieces%beam, varying_of(scene, units, heaviest), pieces%struck)
  end subroutine cut_its_layers

  pure subroutine find_sections(scene, pieces)
    !! Find the sections of tapering pieces, which are parts of those in the scene.
    type(scene_type), intent(in) :: scene          !! with taper
    type(struck_beam), intent(inout) :: pieces
    type(full_units) :: full
    real(qp) :: ends(2)                            ! of a part, from 0 to 1 over the scene's piece
    real(qp) :: outer, length
    integer :: g, i
    full = full_units_of(scene%beam)
    allocate (pieces%section(size(pieces%beam%piece)))
    g = 1
    outer = scene%beam%pieces(1)%length/full%length
    do i = 1, size(pieces%beam%piece)
      ends = [to_quad(joint_position(pieces%beam, i - 1)), to_quad(joint_position(pieces%beam, i))]
      do while (g < size(scene%beam%pieces) .and. 0.5_qp*sum(ends) > outer)
        g = g + 1
        outer = outer + scene%beam%pieces(g)%length/full%length
      end do
      length = scene%beam%pieces(g)%length/full%length
      ends = max(0.0_qp, min(1.0_qp, 1 - (outer - ends)/length))
      associate (inner => scene%beam%pieces(g), tip => scene%beam%outer(g), piece => pieces%beam%piece(i), law => pieces%section(i))
        call set_law(stiffness_law(inner, tip)/full%stiffness, ends, piece%stiffness, law%stiffness)
        call set_law(mass_law(inner, tip)/full%mass*full%length, ends, piece%mass, law%mass)
        law%shear = [1.0_dp]
        law%rotary = [1.0_dp]
        law%tension = [0.0_dp]
        if (.not. allocated(scene%shear) .or. inner%is_lumped) cycle
        call set_law(stretch_law(inner, tip)/full%stiffness*full%length**2, ends, piece%compliance, law%shear)
        piece%compliance = to_dd(2*(1 + real(scene%shear%poisson_ratio, qp))/scene%shear%shear_coefficient &
                                 /to_quad(piece%compliance))
        call set_law(rotary_law(inner, tip)/full%mass/full%length, ends, piece%rotary, law%rotary)
      end associate
    end do
  end subroutine find_sections

  pure subroutine set_law(whole, ends, value, law)
    !! Return part of a polynomial: its value at the inner end, and the rest over that.
    real(qp), intent(in) :: whole(0:)
    real(qp), intent(in) :: ends(2)                !! of the part
    type(dd), intent(out) :: value
    real(dp), allocatable, intent(out) :: law(:)
    real(qp) :: part(0:size(whole) - 1)
    integer :: i, j, n
    n = size(whole) - 1
    part = whole                                   ! shift of the origin by Horner's scheme
    do i = 0, n - 1
      do j = n - 1, i, -1
        part(j) = part(j) + ends(1)*part(j + 1)
      end do
    end do
    part = part*[((ends(2) - ends(1))**i, i=0, n)]
    value = to_dd(part(0))
    law = real(part/part(0), dp)
  end subroutine set_law

  pure type(varying_beam) function varying_of(scene, units, pieces) result(varying)
    !! Return the beam with its tension and the variation of its sections.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(struck_beam), intent(in) :: pieces
    if (allocated(scene%stiffening)) then
      varying = under_tension(pieces%beam, scene%stiffening%hub_radius/units%length, pieces%section)
    else
      varying = without_tension(pieces%beam, pieces%section)
    end if
  end function varying_of

  pure subroutine in_uniform_parts(pieces)
    !! Replace taper by steps, for estimates.
    type(struck_beam), intent(inout) :: pieces
    type(varying_beam) :: varying
    if (.not. allocated(pieces%section)) return
    varying = without_tension(pieces%beam, pieces%section)
    pieces%beam = stepped(varying)
    pieces%struck = soft_parts*pieces%struck
    deallocate (pieces%section)
  end subroutine in_uniform_parts

  pure real(dp) function mass_struck(scene, units) result(mass)
    !! Return the mass of the bodies at the struck place, in m_i.
    type(scene_type), intent(in) :: scene          !! without sweeps, with an impact
    type(beam_units), intent(in) :: units
    type(struck_beam) :: pieces
    mass = 0.0_dp
    if (.not. allocated(scene%bodies)) return
    pieces = pieces_of(scene, units, .false.)
    mass = pieces%beam%joint(pieces%struck)%mass%hi
  end function mass_struck

  pure function joints_of_bodies(scene) result(joints)
    !! Return the bodies of a scene with their springs, without dimensions, (bodies).
    type(scene_type), intent(in) :: scene
    type(beam_joint), allocatable :: joints(:)
    integer :: i
    allocate (joints(0))
    if (.not. allocated(scene%bodies)) return
    joints = [(joint_of(scene%bodies(i), full_units_of(scene%beam)), i=1, size(scene%bodies))]
  end function joints_of_bodies

  pure type(full_units) function full_units_of(beam) result(full)
    type(beam_par), intent(in) :: beam
    full%length = beam%length
    if (allocated(beam%pieces)) full%length = sum(real(beam%pieces%length, qp))
    full%stiffness = beam%youngs_modulus*second_moment_of(beam%beam_piece)
    if (allocated(beam%pieces)) full%stiffness = beam%pieces(1)%youngs_modulus*second_moment_of(beam%pieces(1))
    full%mass = beam_mass(beam)
  end function full_units_of

  elemental type(uniform_piece) function piece_of(given, full) result(piece)
    type(beam_piece), intent(in) :: given
    type(full_units), intent(in) :: full
    piece%length = to_dd(given%length/full%length)
    piece%stiffness = to_dd(given%youngs_modulus*second_moment_of(given)/full%stiffness)
    piece%mass = to_dd(piece_mass(given)/given%length*full%length/full%mass)
  end function piece_of

  elemental subroutine add_shear(given, shear, full, piece)
    !! Set 1/(κGA) = 2(1 + ν)/κ · 1/(EA), with the shear modulus E/(2(1 + ν)), and ρI; neither if only ρA and EI are given.
    type(beam_piece), intent(in) :: given
    type(shear_par), intent(in) :: shear
    type(full_units), intent(in) :: full
    type(uniform_piece), intent(inout) :: piece
    if (given%is_lumped) return
    piece%compliance = to_dd(2*(1 + real(shear%poisson_ratio, qp))/shear%shear_coefficient &
                             /(given%youngs_modulus*area_of(given))*(full%stiffness/full%length**2))
    piece%rotary = to_dd(given%density*second_moment_of(given)/full%mass/full%length)
  end subroutine add_shear

  pure type(beam_root) function root_of(support, full) result(root)
    !! Return the support of the root. Springs that are not given are rigid.
    type(support_par), intent(in) :: support
    type(full_units), intent(in) :: full
    root%holds_deflection = .not. allocated(support%stiffness)
    root%holds_turning = .not. allocated(support%rotational_stiffness)
    if (allocated(support%stiffness)) root%stiffness = spring_of(support%stiffness/full%stiffness*full%length**3)
    if (allocated(support%rotational_stiffness)) then
      root%turning_stiffness = spring_of(support%rotational_stiffness/full%stiffness*full%length)
    end if
  end function root_of

  pure type(beam_joint) function tip_of(support, full) result(tip)
    !! Return the tip's support. Springs that are not given are rigid to rounding.
    type(support_par), intent(in) :: support
    type(full_units), intent(in) :: full
    tip%stiffness = to_dd(rigid)
    tip%turning_stiffness = to_dd(rigid)
    if (allocated(support%stiffness)) tip%stiffness = spring_of(support%stiffness/full%stiffness*full%length**3)
    if (allocated(support%rotational_stiffness)) then
      tip%turning_stiffness = spring_of(support%rotational_stiffness/full%stiffness*full%length)
    end if
  end function tip_of

  pure type(beam_joint) function joint_of(body, full) result(joint)
    type(body_par), intent(in) :: body
    type(full_units), intent(in) :: full
    joint%mass = dd(body%mass_ratio, body%mass_ratio_low)
    joint%inertia = to_dd(body%rotary_inertia/full%mass/full%length**2)
    joint%stiffness = spring_of(body%stiffness/full%stiffness*full%length**3)
    joint%turning_stiffness = spring_of(body%rotational_stiffness/full%stiffness*full%length)
  end function joint_of

  pure type(dd) function spring_of(stiffness) result(spring)
    !! Return a stiffness in EI/l³ or EI/l. Beyond the range of other inputs (bw_scene_scales) it is rigid to rounding.
    real(qp), intent(in) :: stiffness
    spring = to_dd(min(stiffness, real(rigid, qp)))
  end function spring_of

end module bw_scene_pieces

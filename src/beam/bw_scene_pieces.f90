module bw_scene_pieces
  !! The beam of a scene without tension as uniform pieces with bodies and springs at their ends, without dimensions: lengths
  !! in l, times in l²/h, masses in m_i, so that EI and ρA of a uniform beam are 1. Numbers are double-double.
  use bw_beam_par, only: beam_par
  use bw_beam_units, only: beam_units
  use bw_double_double, only: dd, to_dd, operator(+), operator(*), operator(/)
  use bw_kinds, only: dp
  use bw_piece_beam, only: attach, beam_joint, cut_at, piece_beam, uniform_piece
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: scene_type
  use bw_shear_par, only: shear_par
  implicit none (type, external)
  private
  public :: pieces_of

  type, public :: struck_beam
    !! A beam of pieces, and what strikes it.
    type(piece_beam) :: beam
    integer :: struck = 1                          !! the joint at which the mass strikes, of the beam with and without it
    type(beam_joint) :: captured                   !! what the beam has there of the mass that it has captured
  end type struck_beam

contains

  pure type(struck_beam) function pieces_of(scene, units, loaded) result(pieces)
    !! The beam with all that the scene attaches to it.
    type(scene_type), intent(in) :: scene          !! without sweeps, without tension
    type(beam_units), intent(in) :: units
    logical, intent(in) :: loaded                  !! the captured body is there
    associate (beam => pieces%beam)
      allocate (beam%piece(1), beam%joint(1))
      if (allocated(scene%shear)) call add_shear(scene%beam, scene%shear, beam%piece(1))
      if (allocated(scene%rotation)) then
        associate (omega => dimensionless_speed(scene%rotation, units))
          beam%spin_squared = omega*omega
        end associate
        beam%in_plane = acts_in_plane(scene%rotation)
      end if
      if (loaded) then
        pieces%captured%mass = dd(scene%impact%mass_ratio, scene%impact%mass_ratio_low)
        pieces%captured%inertia = to_dd(scene%capture%rotary_inertia)/to_dd(units%mass)/to_dd(units%length)/to_dd(units%length)
      end if
      call cut_at(beam, to_dd(1.0_dp), pieces%struck)
      call attach(beam, to_dd(1.0_dp), pieces%captured)
    end associate
  end function pieces_of

  pure subroutine add_shear(beam, shear, piece)
    !! 1/(κGA) = 2(1 + ν)/κ · 1/(EA), the shear modulus being E/(2(1 + ν)), and ρI.
    type(beam_par), intent(in) :: beam
    type(shear_par), intent(in) :: shear
    type(uniform_piece), intent(inout) :: piece
    type(dd) :: radius                             ! √(I/A) over the length
    if (beam%round) then
      radius = to_dd(0.25_dp*beam%diameter)/to_dd(beam%length)
      piece%rotary = radius*radius
    else
      piece%rotary = to_dd(beam%second_moment)/to_dd(beam%area)/to_dd(beam%length)/to_dd(beam%length)
    end if
    piece%compliance = (to_dd(1.0_dp) + shear%poisson_ratio)*2.0_dp/to_dd(shear%shear_coefficient)*piece%rotary
  end subroutine add_shear

end module bw_scene_pieces

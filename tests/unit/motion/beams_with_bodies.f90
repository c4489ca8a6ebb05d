module beams_with_bodies
  !! Clamped beams with one body.
  use bw_change_of_bodies, only: body_type
  use bw_double_double, only: to_dd
  use bw_kinds, only: dp
  use bw_mode_set, only: configuration_type, first_numbers
  use bw_piece_beam, only: attach, beam_joint, piece_beam
  use bw_piece_set, only: piece_set
  use bw_piece_source, only: set_of_pieces
  implicit none (type, external)
  private
  public :: beam_with

contains

  type(configuration_type) function beam_with(body, modes) result(configuration)
    !! A body at 0.6.
    type(body_type), intent(in) :: body
    integer, intent(in) :: modes
    type(piece_beam) :: beam
    type(piece_set), allocatable :: set
    allocate (beam%piece(1), beam%joint(1), set)
    call attach(beam, to_dd(0.6_dp), beam_joint(to_dd(body%mass), to_dd(body%inertia), to_dd(body%stiffness), &
                                               to_dd(body%turning_stiffness)))
    call set_of_pieces(beam, first_numbers(modes), set=set)
    call move_alloc(set, configuration%set)
  end function beam_with

end module beams_with_bodies

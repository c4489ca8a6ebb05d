module bw_modes_below_rest
  !! Modes of a beam of pieces with λ < 0: out of plane rotation may destabilise the sections.
  use bw_double_double, only: operator(*)
  use bw_kinds, only: dp
  use bw_mode_probe, only: count_below, mode_probe, piece_system, probe_at, probe_for, system_of
  use bw_piece_beam, only: cut_all, piece_beam
  use bw_piece_waves, only: parts_at_rest
  implicit none (type, external)
  private
  public :: growing_modes, may_grow

contains

  pure integer function growing_modes(beam, floats) result(number)
    !! Count modes with λ < 0, by pieces that are short there. A free beam is pinned, as rigid motions do not matter.
    type(piece_beam), intent(in) :: beam
    logical, intent(in) :: floats                  !! deflection is free
    type(piece_beam) :: fine
    type(piece_system) :: system
    type(mode_probe) :: probe
    real(dp) :: regular
    fine = cut_all(beam, parts_at_rest(beam))
    if (floats) fine%root%holds_deflection = .true.
    system = system_of(fine)
    probe = probe_for(system)
    call probe_at(system, beam%spin_squared*(-1.0e-24_dp), probe)
    call count_below(system, probe, number, regular)
  end function growing_modes

  pure logical function may_grow(beam)
    !! Return whether rotary inertia may destabilise the beam out of plane.
    type(piece_beam), intent(in) :: beam
    may_grow = .not. beam%in_plane .and. beam%spin_squared%hi > 0.0_dp .and. any(beam%piece%rotary%hi > 0.0_dp)
  end function may_grow

end module bw_modes_below_rest

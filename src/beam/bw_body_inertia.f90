module bw_body_inertia
  !! Rotary inertia of the captured body.
  use bw_kinds, only: dp
  use bw_beam_units, only: beam_units
  use bw_capture_par, only: capture_par
  implicit none (type, external)
  private
  public :: body_inertia

contains

  pure real(dp) function body_inertia(capture, units) result(inertia)
    !! J in m_i l². The body turns with the section at the tip; out of plane it is taken as isotropic.
    type(capture_par), intent(in) :: capture
    type(beam_units), intent(in) :: units
    inertia = capture%rotary_inertia/units%mass/units%length/units%length
  end function body_inertia

end module bw_body_inertia

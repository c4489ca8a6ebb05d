module bw_mass_or_ratio
  !! A mass given in kg, or as its ratio to the mass of the beam; the other of the two is derived.
  use bw_input_values, only: group_values
  use bw_kinds, only: dp, qp
  use bw_scene_messages, only: message_list, round_product
  implicit none (type, external)
  private
  public :: build_mass, check_mass

  type, public :: mass_par
    real(dp) :: mass = 0.0_dp               !! [kg], ≥ 0, given or γ m_i
    real(dp) :: mass_ratio = 0.0_dp         !! γ, ratio to the mass of the beam, ≥ 0, given or derived
    real(dp) :: mass_ratio_low = 0.0_dp     !! remainder of a derived ratio beyond double precision
    logical :: mass_given = .false.         !! the mass was given, and the ratio is derived
  end type mass_par

contains

  pure subroutine check_mass(group, line, more, messages)
    !! Check that the mass is given in one of its two ways.
    type(group_values), intent(in) :: group
    integer, intent(in) :: line                  !! of a group that may be repeated; 0 for any other
    character(*), intent(in) :: more             !! end of the message
    type(message_list), intent(inout) :: messages
    if (group%given('mass') .or. group%given('mass_ratio')) return
    call messages%add(line, trim(group%group)//'%mass', 'is missing; accepted: mass or mass_ratio'//more)
  end subroutine check_mass

  pure subroutine build_mass(values, beam_mass, mass, messages)
    !! Build a mass from checked values; derive the mass or its ratio from the other.
    type(group_values), intent(in) :: values
    real(qp), intent(in) :: beam_mass            !! m_i [kg], > 0
    class(mass_par), intent(inout) :: mass
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: place
    place = trim(values%group)//'%mass'
    mass%mass_given = values%given('mass')
    if (mass%mass_given) then
      mass%mass = values%number('mass')
      call round_product(mass%mass/beam_mass, mass%mass_ratio, values%line_of('mass'), place, &
                          'its ratio to the mass of the beam', messages)
      if (mass%mass_ratio > 0.0_dp) mass%mass_ratio_low = real(mass%mass/beam_mass - mass%mass_ratio, dp)
    else
      mass%mass_ratio = values%number('mass_ratio')
      call round_product(mass%mass_ratio*beam_mass, mass%mass, values%line_of('mass_ratio'), place//'_ratio', &
                          'the mass that it stands for', messages)
    end if
  end subroutine build_mass

end module bw_mass_or_ratio

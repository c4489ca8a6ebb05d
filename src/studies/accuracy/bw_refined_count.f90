module bw_refined_count
  !! How many roots of a run are solved in extended precision.
  use bw_beam_units, only: beam_units, units_of
  use bw_case_modes, only: record_stretch
  use bw_double_double, only: dd
  use bw_frequency_equation, only: root_type
  use bw_kinds, only: dp
  use bw_refined_root, only: is_coarse
  use bw_root_list, only: root_values, solve_roots
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: scene_type
  use bw_scene_method, only: changes_shapes
  implicit none (type, external)
  private
  public :: refined_count

  integer, parameter :: batch = 4096       !! roots held at a time

contains

  pure integer function refined_count(scene, count) result(refined)
    !! Of the first `count` modes of beam and mass.
    type(scene_type), intent(in) :: scene  !! without sweeps, with a response
    integer, intent(in) :: count
    type(beam_units) :: units
    type(dd), allocatable :: omega
    integer :: first, k
    refined = 0
    if (changes_shapes(scene)) return        ! modes without a closed form have no roots
    units = units_of(scene%beam)
    if (allocated(scene%rotation)) then
      if (acts_in_plane(scene%rotation)) omega = dimensionless_speed(scene%rotation, units)
    end if
    do first = 1, count, batch
      refined = refined + coarse_roots([(k, k=first, min(first + batch - 1, count))], scene%impact%mass_ratio, omega, &
                                       record_stretch(scene)*(scene%response%duration/units%time%hi))
    end do
  end function refined_count

  pure integer function coarse_roots(number, gamma, omega, longest) result(coarse)
    integer, intent(in) :: number(:)
    real(dp), intent(in) :: gamma, longest
    type(dd), intent(in), optional :: omega
    type(root_type) :: roots(size(number))
    type(dd) :: alpha(size(number))
    roots = solve_roots(number, gamma)
    alpha = root_values(roots)
    coarse = count(is_coarse(roots%rest, alpha%hi, omega, longest))
  end function coarse_roots

end module bw_refined_count

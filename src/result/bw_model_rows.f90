module bw_model_rows
  !! The modal model of a case (bw_modal_model) in a result: a row for each variable.
  use bw_case_result, only: modal_model
  use bw_result_table, only: result_table
  implicit none (type, external)
  private
  public :: model_rows

contains

  subroutine model_rows(table, model)
    !! Put the modal model.
    class(result_table), intent(inout) :: table
    type(modal_model), intent(in), optional :: model
    character(*), parameter :: at_points = 'mode point', by_force = 'point_too point', &
      rest = 'what all other modes add to the ', of_force = ' of each point under a force of 1 N at point_too, a point likewise', &
      of_base = ' of each point where the base is accelerated by 1 m s-2'
    if (table%real_row('modal_stiffness', 'mode', 'N m-1', 'modal stiffness M beta**2')) &
      call table%put(model%stiffness)
    if (table%real_row('modal_damping', 'mode', 'N s m-1', 'modal damping')) call table%put(model%damping)
    if (table%real_row('participation', 'mode', 'kg', 'integral of mass times shape')) &
      call table%put(model%participation)
    if (table%real_row('turn_participation', 'mode', 'kg m', 'integral of mass times shape times distance from the root')) &
      call table%put(model%turn_participation)
    if (table%real_row('shape_at_points', at_points, '1', 'mode shape at the points')) &
      call table%put_columns(model%shape)
    if (table%real_row('slope_at_points', at_points, 'm-1', 'slope of the mode shape, with shear the turning of the section')) &
      call table%put_columns(model%slope)
    if (table%real_row('moment_at_points', at_points, 'N', 'bending moment of the mode')) &
      call table%put_columns(model%moment)
    if (table%real_row('shear_at_points', at_points, 'N m-1', 'shear force of the mode')) &
      call table%put_columns(model%shear)
    if (table%real_row('residual_flexibility', by_force, 'm N-1', rest//'displacement'//of_force)) &
      call table%put_columns(transpose(model%residual(:, :, 1)))
    if (table%real_row('residual_moment', by_force, 'm', rest//'bending moment'//of_force)) &
      call table%put_columns(transpose(model%residual(:, :, 2)))
    if (table%real_row('residual_shear', by_force, '1', rest//'shear force'//of_force)) &
      call table%put_columns(transpose(model%residual(:, :, 3)))
    if (table%real_row('residual_of_base', 'point', 's2', rest//'displacement'//of_base)) &
      call table%put(model%base_residual(:, 1))
    if (table%real_row('residual_moment_of_base', 'point', 'kg m', rest//'bending moment'//of_base)) &
      call table%put(model%base_residual(:, 2))
    if (table%real_row('residual_shear_of_base', 'point', 'kg', rest//'shear force'//of_base)) &
      call table%put(model%base_residual(:, 3))
    if (table%real_row('hub_turn', 'mode', 'm-1', 'turn of the hub in the mode', needs='hub')) call table%put(model%hub_turn)
    if (table%real_row('residual_hub_turn', 'point_too', 'N-1', rest//'turn of the hub under a force of 1 N at point_too', &
                       needs='hub')) call table%put(model%hub_residual)
    if (table%real_row('residual_hub_turn_of_base', '', 's2 m-1', &
                       rest//'turn of the hub where the base is accelerated by 1 m s-2', needs='hub')) &
      call table%put([model%base_hub_residual])
    if (table%real_row('initial_modal_displacement', 'mode', 'm', 'modal displacement after all that happens at t = 0')) &
      call table%put(model%initial_displacement)
    if (table%real_row('initial_modal_velocity', 'mode', 'm s-1', 'modal velocity after all that happens at t = 0')) &
      call table%put(model%initial_velocity)
    if (table%real_row('moving_mass', '', 'kg', 'mass of the beam and of what it carries')) &
      call table%put([model%mass])
  end subroutine model_rows

end module bw_model_rows

module bw_piece_critical
  !! The lowest angular velocity at which a mode of a beam of pieces is unstable. There β² = 0.
  !!
  !! In the plane of rotation that is λ = Ω², without load on rotation of sections: the lowest frequency without rotary inertia
  !! of sections and bodies, and without angular velocity. Out of plane it is λ = 0, where the centrifugal force acts on the
  !! sections of a beam with shear, ρI Ω² on ψ: a rotated section comes nearer the axis. That speed is found from the count of
  !! modes with λ < 0. One uniform clamped piece without springs has π/(2r), r² = ρI/(ρA) with EI = ρA = 1.
  use bw_extended_residual, only: refine
  use bw_double_double, only: dd, dd_pi, sqrt, to_dd, operator(*), operator(/)
  use bw_kinds, only: dp
  use bw_mode_search, only: find_mode, mode_search, search_in
  use bw_piece_beam, only: modes_at_rest, piece_beam
  implicit none (type, external)
  private
  public :: critical_speed_of, without_inertia

contains

  type(dd) function critical_speed_of(beam) result(omega)
    !! Return it in the units of the beam; 0 if there is none, and for a beam that can rotate freely, which is unstable
    !! at any speed. A beam without angular velocity is taken to bend in plane.
    type(piece_beam), intent(in) :: beam
    if (beam%spin_squared%hi > 0.0_dp .and. .not. beam%in_plane) then
      omega = speed_out_of_plane(beam)
    else
      omega = speed_in_plane(beam)
    end if
  end function critical_speed_of

  type(dd) function speed_in_plane(beam) result(omega)
    type(piece_beam), intent(in) :: beam
    type(piece_beam) :: bare
    type(mode_search) :: search
    type(dd) :: lambda
    logical :: found
    omega = dd()
    bare = without_inertia(beam)
    if (modes_at_rest(bare) > 0) return
    search = search_in(bare)
    call find_mode(search, 1, lambda, found)
    if (.not. found) return
    call refine(search%system, search%probe, lambda)
    omega = sqrt(lambda)
  end function speed_in_plane

  pure type(piece_beam) function without_inertia(beam) result(bare)
    !! Return the beam without angular velocity and rotary inertia.
    type(piece_beam), intent(in) :: beam
    integer :: i
    bare = beam
    bare%spin_squared = dd()
    do i = 1, size(bare%piece)
      bare%piece(i)%rotary = dd()
      bare%joint(i)%inertia = dd()
    end do
  end function without_inertia

  type(dd) function speed_out_of_plane(beam) result(omega)
    type(piece_beam), intent(in) :: beam
    integer, parameter :: most = 200
    real(dp), parameter :: close_enough = 4.0_dp*epsilon(1.0_dp)
    real(dp) :: low, high, middle
    integer :: i
    omega = dd()
    if (.not. any(beam%piece%rotary%hi > 0.0_dp)) return
    if (size(beam%piece) == 1 .and. beam%root%holds_deflection .and. beam%root%holds_turning .and. &
        .not. any([beam%joint%stiffness%hi, beam%joint%turning_stiffness%hi] > 0.0_dp)) then
      omega = dd_pi*0.5_dp*sqrt(beam%piece(1)%stiffness/beam%piece(1)%rotary)/beam%piece(1)%length
      return
    end if
    low = 0.0_dp
    high = dd_pi%hi*sqrt(minval(beam%piece%stiffness%hi/max(beam%piece%rotary%hi, tiny(1.0_dp))))
    do i = 1, most
      if (is_unstable(beam, high)) exit
      low = high
      high = 2.0_dp*high
    end do
    do i = 1, most
      middle = 0.5_dp*(low + high)
      if (high - low <= close_enough*high) exit
      if (is_unstable(beam, middle)) then
        high = middle
      else
        low = middle
      end if
    end do
    omega = to_dd(middle)
  end function speed_out_of_plane

  logical function is_unstable(beam, speed)
    !! Return whether there is a mode with λ < 0 at an angular velocity.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: speed
    type(piece_beam) :: turning
    type(mode_search) :: search
    turning = beam
    turning%spin_squared = to_dd(speed)*speed
    search = search_in(turning)
    is_unstable = search%growing > 0 .or. .not. search%possible
  end function is_unstable

end module bw_piece_critical

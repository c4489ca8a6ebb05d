module bw_absent_return
  !! When a mass that rebounded would be back at the tip, had the scene `&recontact`: a few thousand values of the gap from
  !! the first modes in closed form, no solve and no search that proves anything.
  use bw_kinds, only: dp
  use bw_absent_effects, only: spin_squared
  use bw_beam_units, only: beam_units, units_of
  use bw_missing, only: missing
  use bw_root_list, only: solve_roots
  use bw_scene, only: scene_type
  use bw_scene_method, only: changes_shapes
  use bw_shape, only: shape_type, shapes_of
  implicit none (type, external)
  private
  public :: return_time

  integer, parameter :: most_modes = 40           !! tuned: of the gap; more add ripples that are over before it shows
  real(dp), parameter :: fine = 0.1_dp            !! tuned: a step in units of the fastest mode, and of the slowest
  real(dp), parameter :: growth = 1.0_dp/64       !! tuned: a step over the time since the impact
  integer, parameter :: halvings = 20

  type :: gap_type
    real(dp), allocatable :: square(:)            !! β² of the modes
    real(dp) :: blow = 0.0_dp                     !! 4H: what each mode's tip velocity jumps by, V
    real(dp) :: speed = 0.0_dp                    !! of the mass after the impact, V
    real(dp) :: spin = 0.0_dp                     !! Ω²
  end type gap_type

contains

  pure real(dp) function return_time(scene) result(time)
    !! s; missing where the mass does not rebound, is followed, or would not be back within the record, and where tension or
    !! shear leave no closed form.
    type(scene_type), intent(in) :: scene         !! without sweeps
    type(gap_type) :: gap
    type(beam_units) :: units
    real(dp) :: longest
    time = missing
    if (.not. allocated(scene%impact) .or. .not. allocated(scene%response)) return
    if (allocated(scene%capture) .or. allocated(scene%recontact) .or. changes_shapes(scene)) return
    if (scene%impact%mass_ratio == 0.0_dp .or. scene%impact%approach_velocity == 0.0_dp) return
    units = units_of(scene%beam)
    gap = gap_of(scene)
    longest = min(scene%response%duration/units%time%hi, out_of_reach(gap))
    time = first_closing(gap, longest)
    if (time < longest) then
      time = time*units%time%hi
    else
      time = missing
    end if
  end function return_time

  pure type(gap_type) function gap_of(scene) result(gap)
    !! Eqs 11 and 12 with φ_i(1)² = 4.
    type(scene_type), intent(in) :: scene
    type(shape_type), allocatable :: shape(:)
    integer :: k, n
    n = scene%modes%before
    shape = shapes_of(solve_roots([(k, k=1, min(n, most_modes))], 0.0_dp))
    gap%spin = spin_squared(scene)
    gap%square = shape%alpha**4 - gap%spin
    associate (gamma => scene%impact%mass_ratio, e => scene%impact%restitution)
      gap%blow = 4.0_dp*(1.0_dp + e)*gamma/(1.0_dp + 4.0_dp*n*gamma)
      gap%speed = (4.0_dp*n*gamma - e)/(1.0_dp + 4.0_dp*n*gamma)
    end associate
  end function gap_of

  pure real(dp) function out_of_reach(gap) result(time)
    !! When the search may end: the mass has gone further than the tip swings, or the tip has swung twice.
    type(gap_type), intent(in) :: gap
    real(dp), parameter :: pi = acos(-1.0_dp)
    time = 4.0_dp*pi/sqrt(max(1.0_dp, abs(gap%square(1))))
    if (any(gap%square <= 0.0_dp)) return
    if (gap%speed < 0.0_dp) time = min(time, sum(gap%blow/sqrt(gap%square))/(-gap%speed))
  end function out_of_reach

  pure real(dp) function first_closing(gap, longest) result(time)
    !! The first time at which the gap is seen closed, 0 where it never opens, `longest` where it stays open.
    type(gap_type), intent(in) :: gap
    real(dp), intent(in) :: longest
    real(dp) :: before, fastest, middle, slowest
    integer :: i
    fastest = fine/sqrt(maxval(abs(gap%square)))
    slowest = fine/sqrt(max(1.0_dp, minval(abs(gap%square))))
    before = 0.0_dp
    time = fastest
    do while (width(gap, time) > 0.0_dp)
      if (time >= longest) return
      before = time
      time = min(longest, time + min(slowest, max(fastest, growth*time)))
    end do
    if (before == 0.0_dp) time = 0.0_dp
    do i = 1, merge(0, halvings, before == 0.0_dp)
      middle = 0.5_dp*(before + time)
      if (width(gap, middle) > 0.0_dp) then
        before = middle
      else
        time = middle
      end if
    end do
  end function first_closing

  pure real(dp) function width(gap, time)
    !! v_tip − y, in V l²/h.
    type(gap_type), intent(in) :: gap
    real(dp), intent(in) :: time
    width = gap%blow*sum(swing(gap%square, time)) - gap%speed*swing(-gap%spin, time)
  end function width

  elemental real(dp) function swing(square, time) result(s)
    !! S of β² and t.
    real(dp), intent(in) :: square, time
    real(dp) :: beta
    beta = sqrt(abs(square))
    s = time
    if (square > 0.0_dp) s = sin(beta*time)/beta
    if (square < 0.0_dp) s = sinh(beta*time)/beta
  end function swing

end module bw_absent_return

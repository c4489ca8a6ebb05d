module bw_absent_return
  !! When a mass that rebounded would be back at the tip, had the scene `&recontact`: a few thousand values of the gap from
  !! the first modes in closed form, no solve and no search that proves anything.
  use bw_absent_effects, only: spin_squared
  use bw_beam_units, only: beam_units, units_of
  use bw_constants, only: pi
  use bw_damping, only: damping_law, law_of
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_root_list, only: solve_roots
  use bw_scene, only: changes_shapes, scene_type
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
    real(dp), allocatable :: damping(:)           !! c of the modes
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
    gap = gap_of(scene, units)
    longest = min(scene%response%duration/units%time%hi, out_of_reach(gap))
    time = first_closing(gap, longest)
    if (time < longest) then
      time = time*units%time%hi
    else
      time = missing
    end if
  end function return_time

  pure type(gap_type) function gap_of(scene, units) result(gap)
    !! Eqs 11 and 12 with φ_i(1)² = 4.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(shape_type), allocatable :: shape(:)
    type(damping_law) :: law                       ! nothing damps where the scene does not name it
    integer :: k, n
    n = scene%modes%before
    shape = shapes_of(solve_roots([(k, k=1, min(n, most_modes))], 0.0_dp))
    gap%spin = spin_squared(scene)
    gap%square = shape%alpha**4 - gap%spin
    if (allocated(scene%damping)) law = law_of(scene%damping, units)
    gap%damping = law%rates(shape%alpha**4)
    associate (gamma => scene%impact%mass_ratio, e => scene%impact%restitution)
      gap%blow = 4.0_dp*(1.0_dp + e)*gamma/(1.0_dp + 4.0_dp*n*gamma)
      gap%speed = (4.0_dp*n*gamma - e)/(1.0_dp + 4.0_dp*n*gamma)
    end associate
  end function gap_of

  elemental real(dp) function pace(square, c)
    !! Of a mode: how fast it turns or grows or, where it is overdamped, creeps back.
    real(dp), intent(in) :: square, c
    real(dp) :: turning
    turning = square - 0.25_dp*c**2
    pace = sqrt(max(1.0_dp, abs(turning)))
    if (is_overdamped(square, c)) pace = square/(sqrt(-turning) + 0.5_dp*c)
  end function pace

  elemental logical function is_overdamped(square, c)
    !! Whether a mode creeps back without turning.
    real(dp), intent(in) :: square, c
    is_overdamped = square > 0.0_dp .and. square <= 0.25_dp*c**2
  end function is_overdamped

  pure real(dp) function out_of_reach(gap) result(time)
    !! When the search may end: the mass has gone further than the tip swings, or the tip has swung twice, or crept back.
    type(gap_type), intent(in) :: gap
    real(dp), parameter :: back = 700.0_dp         ! e^(−700) is nothing beside a mass that moves
    time = merge(back, 4.0_dp*pi, is_overdamped(gap%square(1), gap%damping(1)))/pace(gap%square(1), gap%damping(1))
    if (any(gap%square <= 0.0_dp)) return
    if (gap%speed < 0.0_dp) time = min(time, sum(gap%blow/sqrt(gap%square))/(-gap%speed))
  end function out_of_reach

  pure real(dp) function first_closing(gap, longest) result(time)
    !! The first time at which the gap is seen closed, 0 where it never opens, `longest` where it stays open.
    type(gap_type), intent(in) :: gap
    real(dp), intent(in) :: longest
    real(dp) :: before, fastest, middle, slowest
    integer :: i
    fastest = fine/sqrt(maxval(max(abs(gap%square), gap%damping**2)))     ! the faster exponent of an overdamped mode is c
    slowest = fine/minval(pace(gap%square, gap%damping))
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
    width = gap%blow*sum(swing(gap%square, gap%damping, time)) - gap%speed*swing(-gap%spin, 0.0_dp, time)
  end function width

  elemental real(dp) function swing(square, c, time) result(s)
    !! What a mode does after a blow: e^(−ct/2) S of β² − c²/4 and t, with joined exponents where it does not turn.
    real(dp), intent(in) :: square, c, time
    real(dp) :: turning, beta
    turning = square - 0.25_dp*c**2
    beta = sqrt(abs(turning))
    if (turning > 0.0_dp) then
      s = exp(-0.5_dp*c*time)*sin(beta*time)/beta
    else if (beta*time < 1.0e-4_dp) then           ! the two exponentials would cancel
      s = exp(-0.5_dp*c*time)*time
    else
      s = 0.5_dp*(exp(-square/(beta + 0.5_dp*c)*time) - exp(-(beta + 0.5_dp*c)*time))/beta
    end if
  end function swing

end module bw_absent_return

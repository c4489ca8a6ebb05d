module random_beams
  !! Random beams of pieces for tests: of all sorts, and such as make modes hard to tell apart. The same after the same `start_draws`.
  use bw_double_double, only: to_dd, operator(*)
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam
  implicit none (type, external)
  private
  public :: beam_of_kind, random_beam

  integer, parameter, public :: kinds = 4

contains

  type(piece_beam) function random_beam() result(beam)
    !! Up to 5 pieces of all sorts, bodies and springs over many decades, in either plane.
    integer :: n, i
    beam = piece_beam()
    n = 1 + int(5*uniform())
    allocate (beam%piece(n), beam%joint(n))
    do i = 1, n
      beam%piece(i)%length = to_dd(0.1_dp + uniform())
      beam%piece(i)%stiffness = to_dd(between(0.1_dp, 10.0_dp))
      beam%piece(i)%mass = to_dd(between(0.1_dp, 10.0_dp))
      if (uniform() < 0.7_dp) beam%joint(i)%mass = to_dd(between(1e-3_dp, 1e3_dp))
      if (uniform() < 0.5_dp) beam%joint(i)%inertia = to_dd(between(1e-6_dp, 1e1_dp))
      if (uniform() < 0.3_dp) beam%joint(i)%stiffness = to_dd(between(1e-6_dp, 1e12_dp))
      if (uniform() < 0.3_dp) beam%joint(i)%turning_stiffness = to_dd(between(1e-6_dp, 1e12_dp))
    end do
    if (uniform() < 0.6_dp) then
      beam%piece%rotary = to_dd(between(1e-8_dp, 1e-2_dp))
      beam%piece%compliance = beam%piece%rotary*to_dd(2.93_dp)
    end if
    beam%root%holds_deflection = uniform() < 0.7_dp
    beam%root%holds_turning = uniform() < 0.5_dp
    beam%root%stiffness = to_dd(between(1e-6_dp, 1e12_dp))
    beam%root%turning_stiffness = to_dd(between(1e-6_dp, 1e12_dp))
    if (uniform() < 0.7_dp) beam%spin_squared = to_dd(between(1e-4_dp, 1e4_dp))
    beam%in_plane = uniform() < 0.5_dp
  end function random_beam

  type(piece_beam) function extreme_beam() result(beam)
    !! Pieces whose lengths and stiffness differ by six decades, with bodies and springs over 24, held or not.
    integer :: n, i
    beam = piece_beam()
    n = 1 + int(5*uniform())
    allocate (beam%piece(n), beam%joint(n))
    do i = 1, n
      beam%piece(i)%length = to_dd(between(1e-6_dp, 1.0_dp))
      beam%piece(i)%stiffness = to_dd(between(1e-3_dp, 1e3_dp))
      beam%piece(i)%mass = to_dd(between(1e-3_dp, 1e3_dp))
      if (uniform() < 0.5_dp) beam%joint(i)%mass = to_dd(between(1e-12_dp, 1e12_dp))
      if (uniform() < 0.3_dp) beam%joint(i)%inertia = to_dd(between(1e-12_dp, 1e12_dp))
      if (uniform() < 0.3_dp) beam%joint(i)%stiffness = to_dd(between(1e-6_dp, 1e12_dp))
    end do
    beam%root%holds_deflection = uniform() < 0.5_dp
    beam%root%holds_turning = uniform() < 0.5_dp
    beam%spin_squared = to_dd(between(1e-4_dp, 1e4_dp))
    beam%in_plane = uniform() < 0.5_dp
  end function extreme_beam

  type(piece_beam) function nearly_uncoupled() result(beam)
    !! Equal pieces between springs so stiff, or two that are free beside bodies so heavy, that modes come in groups next to
    !! each other, as near as rounding.
    integer :: n
    beam = piece_beam()
    if (uniform() < 0.5_dp) then
      allocate (beam%piece(3), beam%joint(3))
      beam%piece%length = to_dd([0.4_dp, 0.2_dp, 0.4_dp])
      beam%piece(2)%stiffness = to_dd(between(1e-4_dp, 1.0_dp))
      beam%piece(2)%mass = to_dd(between(1e-4_dp, 1.0_dp))
      beam%joint(1:2)%mass = to_dd(between(1.0_dp, 1e6_dp))
      beam%joint(1:2)%inertia = to_dd(between(1.0_dp, 1e6_dp))
      beam%root%holds_deflection = .false.
      beam%root%holds_turning = .false.
      return
    end if
    n = 2 + int(3*uniform())
    allocate (beam%piece(n), beam%joint(n))
    beam%piece%length = to_dd(1.0_dp/n)
    beam%joint%stiffness = to_dd(between(1e4_dp, 1e12_dp))
    beam%joint%turning_stiffness = to_dd(between(1e4_dp, 1e12_dp))
  end function nearly_uncoupled

  type(piece_beam) function noded_beam() result(beam)
    !! A uniform beam, hinged or clamped at the root, hinged or free at the tip, with bodies and springs of all sizes at twelfths
    !! of its length, in nodes of many modes; half of them with shear, whose cutoff is among the first hundreds.
    integer, parameter :: parts = 12
    logical :: cut(parts)
    integer :: last, i, n
    beam = piece_beam()
    cut = [(uniform() < 0.25_dp, i=1, parts - 1), .true.]
    allocate (beam%piece(count(cut)), beam%joint(count(cut)))
    last = 0
    n = 0
    do i = 1, parts
      if (.not. cut(i)) cycle
      n = n + 1
      beam%piece(n)%length = to_dd(real(i - last, dp))*(1.0_dp/parts)
      last = i
      if (uniform() < 0.7_dp) beam%joint(n)%mass = to_dd(between(1e-6_dp, 1e12_dp))
      if (uniform() < 0.3_dp) beam%joint(n)%inertia = to_dd(between(1e-9_dp, 1e12_dp))
      if (uniform() < 0.3_dp) beam%joint(n)%stiffness = to_dd(between(1e-12_dp, 1e12_dp))
    end do
    if (uniform() < 0.5_dp) beam%joint(n)%stiffness = to_dd(1e30_dp)
    if (uniform() < 0.5_dp) then
      beam%piece%rotary = to_dd(between(1e-6_dp, 1.6e-2_dp))
      beam%piece%compliance = beam%piece%rotary*to_dd(2.93_dp)
    end if
    beam%root%holds_turning = uniform() < 0.5_dp
    beam%spin_squared = to_dd(between(1e-4_dp, 1e4_dp))
    beam%in_plane = uniform() < 0.5_dp
  end function noded_beam

  type(piece_beam) function beam_of_kind(kind) result(beam)
    integer, intent(in) :: kind                    !! from 0 to kinds − 1
    select case (kind)
    case (0)
      beam = random_beam()
    case (1)
      beam = nearly_uncoupled()
    case (2)
      beam = extreme_beam()
    case default
      beam = noded_beam()
    end select
  end function beam_of_kind

  real(dp) function uniform()
    call random_number(uniform)
  end function uniform

  real(dp) function between(low, high)
    real(dp), intent(in) :: low, high
    between = low*(high/low)**uniform()
  end function between

end module random_beams

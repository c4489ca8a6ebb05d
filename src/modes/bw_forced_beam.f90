module bw_forced_beam
  !! The exact response of a beam of pieces to a force F e^(iΩt), without modes: its boundary value problem at a complex frequency.
  !!
  !! Undamped, β² = Ω² is real. Mass-proportional Rayleigh damping, a, subtracts iΩa from β²; stiffness-proportional
  !! damping, b, multiplies all elasticity by 1 + iΩb. One damping ratio for all modes has no such operator, and tension
  !! no such waves; bw_modal_response treats them by modal sums. Without dimensions, as the beam.
  use bw_beam_states, only: crossing_type, support_states, inertia_at, inertia_type, states_before_joint, lead_from_root, &
    lead_from_tip, mirrored, &
    motion_within, solve
  use bw_double_double, only: dd, to_dd
  use bw_kinds, only: dp
  use bw_piece_beam, only: beam_root, cut_at, is_held, joint_position, piece_beam
  implicit none (type, external)
  private

  type :: beam_point
    !! A place on a leg: a piece, and the distance beyond its near end.
    integer :: piece = 0                         !! 0: at the force
    real(dp) :: way = 0.0_dp
    logical :: to_tip = .true.                   !! on the leg to the tip; else on that to the root
    logical :: held = .false.                    !! at a rigidly held end
  end type beam_point

  type, public :: forced_beam
    !! A beam with the place of a force, and points.
    type(piece_beam), private :: beam            !! with a joint where the force acts
    integer, private :: forced = 0               !! the joint
    logical, private :: held = .false.           !! the force acts at a rigidly held end
    type(beam_point), allocatable, private :: point(:)
    type(crossing_type), allocatable, private :: to_tip(:), to_root(:)   !! legs at the last frequency
  contains
    procedure :: place
    procedure :: points
    procedure :: respond
  end type forced_beam

contains

  pure subroutine place(self, beam, position, xi)
    !! Place a force and points on a beam.
    class(forced_beam), intent(inout) :: self
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: position             !! of the force, 0 ≤ ξ ≤ 1
    real(dp), intent(in) :: xi(:)                !! of the points, 0 ≤ ξ ≤ 1
    real(dp) :: ends(0:size(beam%piece) + 1)
    type(dd) :: there
    integer :: i, p, n
    self%beam = beam
    self%forced = 0
    if (position > 0.0_dp) call cut_at(self%beam, to_dd(position), self%forced)
    n = size(self%beam%piece)
    do i = 0, n
      there = joint_position(self%beam, i)
      ends(i) = there%hi
    end do
    self%point = spread(beam_point(), 1, size(xi))
    self%held = is_held(beam, position)
    do p = 1, size(xi)
      associate (point => self%point(p), here => ends(self%forced))
        point%held = is_held(beam, xi(p))
        point%to_tip = xi(p) > here
        if (point%to_tip) then
          i = min(count(ends(1:n) < xi(p)) + 1, n)
          point%piece = i - self%forced
          point%way = min(xi(p) - ends(i - 1), ends(i) - ends(i - 1))
        else if (xi(p) < here) then
          i = min(count(ends(1:n) < xi(p)) + 1, self%forced)
          point%piece = self%forced + 1 - i
          point%way = ends(i) - xi(p)
        end if
      end associate
    end do
    if (allocated(self%to_tip)) deallocate (self%to_tip, self%to_root)
    allocate (self%to_tip(n - self%forced), self%to_root(self%forced))
  end subroutine place

  pure integer function points(self)
    !! Return the number of points.
    class(forced_beam), intent(in) :: self
    points = size(self%point)
  end function points

  pure subroutine respond(self, square, loss, v)
    !! Find the deflection of each point under a force of 1.
    class(forced_beam), intent(inout) :: self
    complex(dp), intent(in) :: square            !! β² of the motion: Ω², less iΩa if damped
    complex(dp), intent(in) :: loss              !! iΩb; 0 without damping of elasticity
    complex(dp), intent(out) :: v(:)             !! (points)
    type(inertia_type) :: inertia
    complex(dp) :: sides(4, 4), equations(4, 4), amplitude(4), here
    integer :: p
    v = 0.0_dp
    if (self%held) return
    inertia = inertia_at(self%beam, square, loss)
    call lead_from_tip(self%beam, self%forced, inertia, self%to_tip)
    call lead_from_root(self%beam, self%forced, inertia, self%to_root)
    sides(:, :2) = near_end(self%to_tip, beam_root(.false., .false.))
    if (self%forced > 0) sides(:, :2) = states_before_joint(self%beam%joint(self%forced), inertia, sides(:, :2))
    sides(:, 3:) = -mirrored(near_end(self%to_root, self%beam%root))
    amplitude = [0.0_dp, 0.0_dp, 0.0_dp, -1.0_dp]
    equations = sides
    call solve(equations, amplitude)
    here = sum(sides(1, :2)*amplitude(:2))
    do p = 1, size(v)
      associate (point => self%point(p))
        if (point%held) then
          v(p) = 0.0_dp
        else if (point%piece == 0) then
          v(p) = here
        else if (point%to_tip) then
          v(p) = deflection_on(self%to_tip, amplitude(:2), point)
        else
          v(p) = deflection_on(self%to_root, amplitude(3:), point)
        end if
      end associate
    end do
    v = v/(1.0_dp + loss)
  end subroutine respond

  pure function near_end(leg, root) result(states)
    !! Return the two states of a leg at the force.
    type(crossing_type), intent(in) :: leg(:)
    type(beam_root), intent(in) :: root          !! support of the end, for a leg without pieces
    complex(dp) :: states(4, 2)
    if (size(leg) == 0) then
      states = support_states(root)
    else
      states = leg(1)%near
    end if
  end function near_end

  pure complex(dp) function deflection_on(leg, near, point) result(v)
    !! Return the deflection of a point on a leg from the amplitudes at its near end.
    type(crossing_type), intent(in) :: leg(:)
    complex(dp), intent(in) :: near(2)
    type(beam_point), intent(in) :: point
    complex(dp) :: amplitudes(2)
    integer :: i
    amplitudes = near
    do i = 1, point%piece - 1
      amplitudes = matmul(leg(i)%onwards, matmul(leg(i)%outwards, amplitudes))
    end do
    v = motion_within(leg(point%piece), amplitudes, point%way)
  end function deflection_on

end module bw_forced_beam

module bw_forced_beam
  !! The response of a beam of pieces to a force F e^(iΩt), exactly and without modes: its boundary problem at a complex frequency.
  !!
  !! Undamped it is that of real β² = Ω². Rayleigh's damping of the mass, a, takes iΩa off all β²; that of the elasticity, b, multiplies
  !! all of it by 1 + iΩb. A ratio that all modes share belongs to no such operator, and tension to no such waves: what sums of modes
  !! leave out of those is the matter of bw_modal_response. Without dimensions, as the beam.
  use bw_beam_states, only: crossing_type, ending, inertia_at, inertia_type, joined, lead_from_root, lead_from_tip, mirrored, &
    motion_within, solve
  use bw_double_double, only: dd, to_dd
  use bw_kinds, only: dp
  use bw_piece_beam, only: beam_root, cut_at, is_held, joint_position, piece_beam
  implicit none (type, external)
  private

  type :: beam_point
    !! A place on a leg: in one of its pieces, so far beyond the near end of that.
    integer :: piece = 0                         !! 0: it is where the force is
    real(dp) :: way = 0.0_dp
    logical :: to_tip = .true.                   !! on the leg to the tip; else on that to the root
    logical :: held = .false.                    !! at an end that is held rigidly
  end type beam_point

  type, public :: forced_beam
    !! A beam with the place of a force, and points.
    type(piece_beam), private :: beam            !! with a joint where the force acts
    integer, private :: forced = 0               !! the joint
    logical, private :: held = .false.           !! the force acts where the beam is held rigidly
    type(beam_point), allocatable, private :: point(:)
    type(crossing_type), allocatable, private :: to_tip(:), to_root(:)   !! legs at the last frequency
  contains
    procedure :: place
    procedure :: points
    procedure :: respond
  end type forced_beam

contains

  pure subroutine place(self, beam, position, xi)
    !! Let a force act on a beam.
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
    !! How many there are.
    class(forced_beam), intent(in) :: self
    points = size(self%point)
  end function points

  pure subroutine respond(self, square, loss, v)
    !! Find the deflection of each point under a force of 1.
    class(forced_beam), intent(inout) :: self
    complex(dp), intent(in) :: square            !! β² of the motion: Ω², or less iΩa
    complex(dp), intent(in) :: loss              !! iΩb; 0 where no elasticity damps
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
    if (self%forced > 0) sides(:, :2) = joined(self%beam%joint(self%forced), inertia, sides(:, :2))
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
    !! Two states that a leg allows at the force.
    type(crossing_type), intent(in) :: leg(:)
    type(beam_root), intent(in) :: root          !! how the end is held, of a leg without a piece
    complex(dp) :: states(4, 2)
    if (size(leg) == 0) then
      states = ending(root)
    else
      states = leg(1)%near
    end if
  end function near_end

  pure complex(dp) function deflection_on(leg, near, point) result(v)
    !! The deflection of a point on a leg, whose amplitudes are known at its near end.
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

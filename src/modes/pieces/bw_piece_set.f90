module bw_piece_set
  !! Modes of a beam of uniform pieces: shapes at points, and overlaps with the modes of the same beam with another body.
  !!
  !! Shapes have ∫Φ² dξ = 1 of the beam's part and a tip value of sign (−1)^k. The modal mass holds all mass and inertia:
  !! M_k = ∫ρAΦ² + ρIΨ² dx + Σ mΦ² + JΨ², Ψ the rotation of the sections.
  use bw_damping, only: damping_law
  use bw_double_double, only: dd, operator(+), operator(*)
  use bw_kinds, only: dp
  use bw_missing, only: no_number
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: joint_at, joint_position
  use bw_piece_overlap, only: overlap_sums, piece_modes
  use bw_piece_products, only: turn_product
  use bw_piece_shape, only: beam_place, place_of, states_inside
  use bw_piece_waves, only: frequency_at, piece_frequency
  implicit none (type, external)
  private

  type, extends(mode_set), public :: piece_set
    type(piece_modes) :: modes                   !! amplitudes, from which shapes follow
    real(dp), allocatable :: spun(:)  !! part of M_k on which rotation acts: translations in plane, rotations out of it, (n)
    integer :: struck_joint = 1                  !! joint at which the mass strikes, or was captured
    real(dp) :: body_inertia = 0.0_dp            !! J of the body captured there
  contains
    procedure :: states => states_at
    procedure :: some_shapes => piece_shapes
    procedure :: some_curvatures => piece_curvatures
    procedure :: overlap
    procedure :: elastic => piece_elastic
    procedure :: coupling
    procedure :: body_energy => energy_of_body
    procedure :: find_tip_shears
    procedure :: turnings
    procedure :: motion_at
    procedure :: share_of_turn
    procedure :: number_errors => errors_of_pieces
  end type piece_set

contains

  pure function states_at(self, first, last, xi) result(state)
    !! Return deflection, rotation, moment M = EIψ' and shear force N = κGA(v' − ψ) of modes `first` … `last` at points.
    !! At joints the first two follow from the forces of attachments, where waves would leave only rounding.
    class(piece_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)                !! 0 ≤ ξ ≤ 1, (points)
    real(dp) :: state(4, last - first + 1, size(xi))
    integer, parameter :: at_once = 1024         ! points: work arrays are on the stack
    type(beam_place) :: place(size(xi))
    type(piece_frequency), allocatable :: frequency(:)
    integer, allocatable :: here(:), some(:)
    integer :: i, joint, k, p
    associate (system => self%modes%system)
      place = [(place_of(system%beam, xi(p)), p=1, size(xi))]
      allocate (frequency(first:last))
      do k = first, last
        frequency(k) = frequency_at(system%beam, self%modes%lambda(k))
      end do
      do i = 1, size(system%piece)
        here = pack([(p, p=1, size(xi))], place%piece == i)
        do p = 1, size(here), at_once
          some = here(p:min(p + at_once - 1, size(here)))
          do k = first, last
            state(:, k - first + 1, some) = states_inside(system%piece(i), frequency(k), self%modes%amplitude(:, i, k), &
                                                          place(some)%offset)
          end do
        end do
      end do
      do p = 1, size(xi)
        joint = joint_at(system%beam, xi(p))
        if (joint == 0) state(1:2, :, p) = self%modes%root(:, first:last)
        if (joint <= 0) cycle
        state(1, :, p) = self%modes%deflection(joint, first:last)
        state(2, :, p) = self%modes%turning(joint, first:last)
      end do
    end associate
  end function states_at

  pure function piece_shapes(self, first, last, xi) result(values)
    !! Return the deflections, some modes at a time.
    class(piece_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    integer, parameter :: batch = 64
    real(dp), allocatable :: state(:, :, :)
    integer :: k
    do k = first, last, batch
      state = self%states(k, min(k + batch - 1, last), xi)
      values(k - first + 1:k - first + size(state, 2), :) = state(1, :, :)
    end do
  end function piece_shapes

  pure function piece_curvatures(self, first, last, xi) result(values)
    !! Return the moment over EI of the root piece; at a joint that of the inner piece. Exactly 0 at a tip without rotational load.
    class(piece_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    real(dp) :: state(4, last - first + 1, size(xi))
    integer :: p
    state = self%states(first, last, xi)
    do p = 1, size(xi)
      values(:, p) = state(3, :, p)/self%modes%system%beam%piece(1)%stiffness%hi
      associate (tip => self%modes%system%beam%joint(size(self%modes%system%beam%joint)))
        if (xi(p) == 1.0_dp .and. tip%inertia%hi == 0.0_dp .and. tip%turning_stiffness%hi == 0.0_dp) values(:, p) = 0.0_dp
      end associate
    end do
  end function piece_curvatures

  pure subroutine find_tip_shears(self, shear, known)
    class(piece_set), intent(in) :: self
    real(dp), intent(out) :: shear(:)
    logical, intent(out) :: known
    real(dp) :: state(4, self%count, 1)
    state = self%states(1, self%count, [1.0_dp])
    shear = state(4, :, 1)
    known = .true.
  end subroutine find_tip_shears

  function overlap(self, from, amplitude, with_mass, monitor) result(sums)
    class(piece_set), intent(in) :: self
    class(mode_set), intent(in) :: from          !! of the same pieces, springs and joints
    real(dp), intent(in) :: amplitude(:)
    logical, intent(in) :: with_mass
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    select type (from)
    class is (piece_set)
      sums = overlap_sums(self%modes, from%modes, amplitude, with_mass, monitor)
    class default
      sums = no_number()
    end select
  end function overlap

  pure function piece_elastic(self) result(squares)
    !! Return the elastic part with springs: β² plus the part that rotation subtracts.
    class(piece_set), intent(in) :: self
    type(dd) :: squares(self%count)
    squares = self%beta_squared + self%modes%system%beam%spin_squared*(self%spun/self%modal_mass)
  end function piece_elastic

  pure function energy_of_body(self, q, rate) result(energy)
    !! Return ½Jψ̇² of the captured body. Rotation does no work on its ψ: in plane (ω + ψ̇)² leaves none, out of plane
    !! the body is isotropic.
    class(piece_set), intent(in) :: self
    real(dp), intent(in) :: q(:), rate(:)        !! (modes)
    real(dp) :: energy(2)
    energy = 0.0_dp
    if (self%body_inertia == 0.0_dp .or. size(q) == 0) return
    energy(1) = 0.5_dp*self%body_inertia*dot_product(self%modes%turning(self%struck_joint, :size(rate)), rate)**2
  end function energy_of_body

  pure function turnings(self) result(turning)
    class(piece_set), intent(in) :: self
    real(dp) :: turning(self%count)
    turning = self%modes%turning(self%struck_joint, :)
  end function turnings

  pure function motion_at(self, xi) result(motion)
    class(piece_set), intent(in) :: self
    real(dp), intent(in) :: xi
    real(dp) :: motion(self%count, 2)
    real(dp) :: state(4, self%count, 1)
    state = self%states(1, self%count, [xi])
    motion = transpose(state(1:2, :, 1))
  end function motion_at

  pure function share_of_turn(self) result(share)
    class(piece_set), intent(in) :: self
    real(dp) :: share(self%count)
    type(piece_frequency) :: frequency
    type(dd) :: inner, outer
    integer :: i, k
    share = 0.0_dp
    associate (beam => self%modes%system%beam)
      do i = 1, size(beam%piece)
        inner = joint_position(beam, i - 1)
        outer = joint_position(beam, i)
        share = share + beam%joint(i)%mass%hi*outer%hi*self%modes%deflection(i, :) &
          + beam%joint(i)%inertia%hi*self%modes%turning(i, :)
        do k = 1, self%count
          frequency = frequency_at(beam, self%modes%lambda(k))
          share(k) = share(k) + turn_product(self%modes%system%piece(i), frequency, self%modes%amplitude(:, i, k), inner%hi)
        end do
      end do
    end associate
  end function share_of_turn

  real(dp) function coupling(self, law) result(ratio)
    !! Return the largest coupling of two of the first modes by damping, |C_ij|/√(C_iiC_jj). Modes are orthogonal with
    !! all mass and inertia, but rotation acts on one part only: K_ij is Ω² times the product of two modes in the
    !! rotation of sections, and in plane of bodies too. Products are means over points.
    class(piece_set), intent(in) :: self
    type(damping_law), intent(in) :: law         !! Rayleigh's; one ratio for all modes couples none
    integer, parameter :: first_modes = 60       ! enough: C_ij/√(C_iiC_jj) falls with the mode number
    integer, parameter :: points = 16*first_modes
    real(dp), allocatable :: state(:, :, :), gram(:, :), turning(:)
    real(dp) :: rate(min(first_modes, self%count))
    type(dd) :: elastic(self%count)
    integer :: i, j, n
    ratio = 0.0_dp
    n = size(rate)
    associate (beam => self%modes%system%beam)
      if (beam%spin_squared%hi == 0.0_dp) return
      allocate (gram(n, n), source=0.0_dp)
      if (any(beam%piece%rotary%hi > 0.0_dp)) then
        state = self%states(1, n, [((i - 0.5_dp)/points, i=1, points)])
        do i = 1, points
          associate (place => place_of(beam, (i - 0.5_dp)/points))
            turning = state(2, :, i)/sqrt(self%modal_mass(:n))
            gram = gram + beam%piece(place%piece)%rotary%hi/points*spread(turning, 1, n)*spread(turning, 2, n)
          end associate
        end do
      end if
      if (beam%in_plane) then
        do i = 1, size(beam%joint)
          turning = self%modes%turning(i, :n)/sqrt(self%modal_mass(:n))
          gram = gram + beam%joint(i)%inertia%hi*spread(turning, 1, n)*spread(turning, 2, n)
        end do
      end if
      gram = beam%spin_squared%hi*gram
    end associate
    elastic = self%elastic()
    rate = law%rates(elastic(:n)%hi)
    do j = 1, n
      do i = 1, j - 1
        if (rate(i) > 0.0_dp .and. rate(j) > 0.0_dp) ratio = max(ratio, abs(gram(i, j))/sqrt(rate(i)*rate(j)))
      end do
    end do
    ratio = ratio*law%stiffness
  end function coupling

  pure subroutine errors_of_pieces(self, square_error, mass_error)
    !! Return the errors of β² and M. β² has double-double digits if found for an infinite record, fewer next to another
    !! mode; shapes, and M, have those of binary64.
    class(piece_set), intent(in) :: self
    real(dp), intent(out) :: square_error(:), mass_error(:)
    type(dd) :: elastic(self%count)
    elastic = self%elastic()
    square_error = 1.0e-24_dp*(elastic%hi + abs(self%beta_squared%hi))
    mass_error = 1.0e-14_dp
  end subroutine errors_of_pieces

end module bw_piece_set

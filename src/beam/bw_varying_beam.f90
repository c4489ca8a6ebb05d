module bw_varying_beam
  !! A beam of pieces with properties that vary along a piece: tension due to rotation, and tapering sections.
  !!
  !! Every property is a polynomial in x, from 0 at the inner end of a piece to 1 at the outer, relative to the value in
  !! `piece_beam`. The tension is T(ξ) = Ω²[∫ρA(R + ξ)dξ + Σm_b(R + ξ_b)] over all that lies beyond ξ.
  use bw_double_double, only: dd, to_dd, to_quad, operator(/), operator(*)
  use bw_kinds, only: dp, qp
  use bw_piece_beam, only: beam_joint, joint_position, piece_beam
  implicit none (type, external)
  private
  public :: pull_at, softest, stepped, tension_in_pieces, turning_inertia, under_tension, value_of, without_tension

  integer, parameter, public :: soft_parts = 32   !! uniform parts of each piece in `softest` and `stepped`

  type, public :: piece_law
    !! Coefficients of 1, x, x², … along a piece; the first is 1 except for tension.
    real(dp), allocatable :: stiffness(:)          !! of EI
    real(dp), allocatable :: mass(:)               !! of ρA
    real(dp), allocatable :: shear(:)              !! of κGA
    real(dp), allocatable :: rotary(:)             !! of ρI
    real(dp), allocatable :: tension(:)            !! of T/Ω² due to the beam's own mass, absolute
    real(dp) :: pull = 0.0_dp                      !! Σm_b(R + ξ_b), T/Ω² due to bodies beyond the piece
  end type piece_law

  type, public :: varying_beam
    !! The beam. A component added here, or to `piece_law`, belongs in `same_beam` as well.
    type(piece_beam) :: beam
    type(piece_law), allocatable :: law(:)         !! (pieces)
    logical :: is_pulled = .false.                 !! with tension due to rotation
    real(dp) :: hub_radius = 0.0_dp                !! R in l, with tension
  contains
    procedure :: tapers
    procedure :: tension
    procedure, private :: same_beam
    generic :: operator(==) => same_beam
  end type varying_beam

  abstract interface
    pure real(dp) function value_interface(polynomial, ends) result(value)
      import :: dp
      real(dp), intent(in) :: polynomial(0:), ends(2)
    end function value_interface
  end interface

contains

  pure type(varying_beam) function without_tension(beam, sections) result(varying)
    !! Return the beam with its sections, without tension.
    type(piece_beam), intent(in) :: beam
    type(piece_law), intent(in), optional :: sections(:)   !! absent: uniform pieces
    integer :: i
    varying%beam = beam
    if (present(sections)) then
      varying%law = sections
      return
    end if
    allocate (varying%law(size(beam%piece)))
    do i = 1, size(beam%piece)
      call make_uniform(varying%law(i))
    end do
  end function without_tension

  pure type(varying_beam) function under_tension(beam, hub_radius, sections) result(varying)
    !! Return the same with the tension due to rotation.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: hub_radius             !! R in l
    type(piece_law), intent(in), optional :: sections(:)   !! see `without_tension`
    real(qp) :: outer, inner, bodies, beyond
    integer :: i
    varying = without_tension(beam, sections)
    varying%is_pulled = .true.
    varying%hub_radius = hub_radius
    bodies = 0.0_qp
    beyond = 0.0_qp
    do i = size(beam%piece), 1, -1
      outer = hub_radius + to_quad(joint_position(beam, i))
      inner = hub_radius + to_quad(joint_position(beam, i - 1))
      bodies = bodies + to_quad(beam%joint(i)%mass)*outer
      varying%law(i)%pull = real(bodies, dp)
      call pull_piece(to_quad(beam%piece(i)%mass), to_quad(beam%piece(i)%length), inner, varying%law(i), beyond)
    end do
  end function under_tension

  pure subroutine make_uniform(law)
    type(piece_law), intent(inout) :: law
    law%stiffness = [1.0_dp]
    law%mass = [1.0_dp]
    law%shear = [1.0_dp]
    law%rotary = [1.0_dp]
    law%tension = [0.0_dp]
  end subroutine make_uniform

  pure subroutine pull_piece(mass, length, inner, law, beyond)
    !! Set T/Ω² = T(1) + P(1) − P(x), P' = mL(R + ξ), over the piece.
    real(qp), intent(in) :: mass                   !! ρA at the inner end
    real(qp), intent(in) :: length
    real(qp), intent(in) :: inner                  !! R + ξ at the inner end
    type(piece_law), intent(inout) :: law
    real(qp), intent(inout) :: beyond              !! T/Ω² of the beam at the outer end, then at the inner end
    real(qp) :: pull(0:size(law%mass) + 1)         ! coefficients of P
    integer :: k
    pull = 0.0_qp
    do k = 0, size(law%mass) - 1
      pull(k + 1) = pull(k + 1) + mass*length*law%mass(k + 1)*inner/(k + 1)
      pull(k + 2) = pull(k + 2) + mass*length*law%mass(k + 1)*length/(k + 2)
    end do
    law%tension = real([0.0_qp, -pull(1:)], dp)
    law%tension(1) = real(beyond, dp) - sum(value_of(law%tension, [1.0_dp]))   ! exactly 0 at a free tip
    beyond = beyond + sum(pull)
  end subroutine pull_piece

  pure logical function tapers(self)
    !! Return whether a property of a section varies along a piece.
    class(varying_beam), intent(in) :: self
    integer :: i
    tapers = .false.
    do i = 1, size(self%law)
      associate (law => self%law(i))
        tapers = tapers .or. any([size(law%stiffness), size(law%mass), size(law%shear), size(law%rotary)] > 1)
      end associate
    end do
  end function tapers

  pure function tension(self, i) result(t)
    !! Return T/Ω² as a polynomial in x over piece i, including bodies beyond it.
    class(varying_beam), intent(in) :: self
    integer, intent(in) :: i
    real(dp), allocatable :: t(:)
    t = self%law(i)%tension
    t(1) = t(1) + self%law(i)%pull
  end function tension

  pure function tension_in_pieces(beam, hub_radius) result(t)
    !! Return T/Ω² = t_0 + t_1x + t_2x² in each of several uniform pieces, (3, pieces).
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: hub_radius             !! R in l
    real(dp) :: t(3, size(beam%piece))
    type(varying_beam) :: varying
    integer :: i
    varying = under_tension(beam, hub_radius)
    do i = 1, size(beam%piece)
      t(:, i) = varying%tension(i)
    end do
  end function tension_in_pieces

  pure real(dp) function turning_inertia(self) result(inertia)
    !! Return the moment of inertia about the hub's axis, without the hub.
    type(varying_beam), intent(in) :: self
    real(dp) :: arm
    integer :: i, k
    inertia = 0.0_dp
    do i = 1, size(self%law)
      associate (piece => self%beam%piece(i), law => self%law(i), joint => self%beam%joint(i), &
                 length => self%beam%piece(i)%length%hi)
        arm = self%beam%root%hub_radius%hi + sum(self%beam%piece(:i - 1)%length%hi)
        do k = 1, size(law%mass)
          inertia = inertia + piece%mass%hi*length*law%mass(k)*(arm**2/k + 2.0_dp*arm*length/(k + 1) + length**2/(k + 2))
        end do
        inertia = inertia + piece%rotary%hi*length*sum([(law%rotary(k)/k, k=1, size(law%rotary))])
        inertia = inertia + joint%mass%hi*(arm + length)**2 + joint%inertia%hi
      end associate
    end do
  end function turning_inertia

  pure real(dp) function pull_at(self, i, x) result(pull)
    !! Return the tension at a place of a piece; 0 without tension.
    class(varying_beam), intent(in) :: self
    integer, intent(in) :: i                       !! the piece
    real(dp), intent(in) :: x                      !! from 0 to 1 over it
    pull = 0.0_dp
    if (self%is_pulled) pull = self%beam%spin_squared%hi*(sum(value_of(self%law(i)%tension, [x])) + self%law(i)%pull)
  end function pull_at

  pure function value_of(polynomial, x) result(value)
    !! Return the values of a law at places from 0 to 1 over a piece.
    real(dp), intent(in) :: polynomial(0:), x(:)
    real(dp) :: value(size(x))
    integer :: i
    value = 0.0_dp
    do i = size(polynomial) - 1, 0, -1
      value = polynomial(i) + x*value
    end do
  end function value_of

  pure type(piece_beam) function softest(self) result(beam)
    !! Return a beam of many uniform pieces that is nowhere stiffer or heavier, without tension: under a force that
    !! grows as e^(st) each of its points moves at least as far.
    class(varying_beam), intent(in) :: self
    beam = in_parts(self, least_value)
  end function softest

  pure type(piece_beam) function stepped(self) result(beam)
    !! Return a beam of many uniform pieces with the sections of their middles; its frequencies agree to within about 1e-3.
    class(varying_beam), intent(in) :: self
    beam = in_parts(self, middle_value)
  end function stepped

  pure type(piece_beam) function in_parts(self, uniform_value) result(beam)
    !! Return a beam of uniform parts without tension. Joints keep their attachments.
    class(varying_beam), intent(in) :: self
    procedure(value_interface) :: uniform_value    !! value in place of a polynomial between two places
    integer :: i, j
    beam = self%beam
    beam%piece = [(spread(self%beam%piece(i), 1, soft_parts), i=1, size(self%beam%piece))]
    beam%joint = [(spread(beam_joint(), 1, soft_parts - 1), self%beam%joint(i), i=1, size(self%beam%piece))]
    do i = 1, size(self%beam%piece)
      do j = 1, soft_parts
        associate (law => self%law(i), ends => [j - 1, j]/real(soft_parts, dp), piece => beam%piece((i - 1)*soft_parts + j))
          piece%length = piece%length/to_dd(real(soft_parts, dp))
          piece%stiffness = piece%stiffness*uniform_value(law%stiffness, ends)
          piece%mass = piece%mass*uniform_value(law%mass, ends)
          piece%compliance = piece%compliance/to_dd(uniform_value(law%shear, ends))
          piece%rotary = piece%rotary*uniform_value(law%rotary, ends)
        end associate
      end do
    end do
  end function in_parts

  pure real(dp) function middle_value(polynomial, ends) result(middle)
    real(dp), intent(in) :: polynomial(0:), ends(2)
    middle = sum(value_of(polynomial, [0.5_dp*sum(ends)]))
  end function middle_value

  pure real(dp) function least_value(polynomial, ends) result(least)
    !! Return a lower bound of a positive polynomial between two places, its least Bernstein coefficient.
    real(dp), intent(in) :: polynomial(0:), ends(2)
    real(dp) :: coefficient(0:size(polynomial) - 1), own(0:size(polynomial) - 1)
    integer :: i, j, n
    n = size(polynomial) - 1
    own = polynomial                               ! of powers of x − a, by Horner's scheme
    do i = 0, n - 1
      do j = n - 1, i, -1
        own(j) = own(j) + ends(1)*own(j + 1)
      end do
    end do
    own = own*[((ends(2) - ends(1))**i, i=0, n)]
    do i = 0, n
      coefficient(i) = sum([(own(j)*binomial(i, j)/binomial(n, j), j=0, i)])
    end do
    least = max(tiny(least)*1.0e20_dp, minval(coefficient))
  end function least_value

  pure real(dp) function binomial(n, k)
    integer, intent(in) :: n, k
    integer :: i
    binomial = 1.0_dp
    do i = 1, k
      binomial = binomial*(n - k + i)/i
    end do
  end function binomial

  pure logical function same_beam(self, other) result(same)
    !! Compare two beams bitwise: equal beams have the same modes.
    class(varying_beam), intent(in) :: self
    type(varying_beam), intent(in) :: other
    integer :: i
    same = self%beam == other%beam .and. self%hub_radius == other%hub_radius .and. (self%is_pulled .eqv. other%is_pulled)
    if (.not. same) return
    do i = 1, size(self%law)
      associate (a => self%law(i), b => other%law(i))
        same = same .and. alike(a%stiffness, b%stiffness) .and. alike(a%mass, b%mass) .and. alike(a%shear, b%shear) &
          .and. alike(a%rotary, b%rotary) .and. alike(a%tension, b%tension) .and. a%pull == b%pull
      end associate
    end do
  end function same_beam

  pure logical function alike(a, b)
    real(dp), intent(in) :: a(:), b(:)
    alike = size(a) == size(b)
    if (alike) alike = all(a == b)
  end function alike

end module bw_varying_beam

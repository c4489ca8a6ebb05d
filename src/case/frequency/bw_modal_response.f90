module bw_modal_response
  !! The response to a harmonic force by n modes, with a correction r for all others:
  !!
  !!     H(Ω) = Σ Φ_kΦ_k(ξ_f)/(M_k(β_k² − Ω² + ic_kΩ)) + r(Ω² − ic_nΩ).
  !!
  !! r is the exact response of uniform pieces without tension less that of their n modes, with the damping of the n-th mode. It
  !! has no poles near Ω, so it is taken as the mean of its values above and below the real axis, off the poles of both parts. r
  !! neglects the effect of tension and of differing damping on omitted modes; the sum of n/2 modes estimates that error.
  !!
  !! On a free hub Φ_k(ξ_f) is the displacement in the frame, on which the force does work, and Φ_k(ξ) that from the hub's line.
  !! There r follows from the responses to forces that grow as e^(st), which have no poles (bw_static_shape): a polynomial in s²
  !! through four of them, at s² = −Ω² + ic_nΩ. With Rayleigh damping s² = (−Ω² + iaΩ)/(1 + ibΩ), and r is divided by 1 + ibΩ.
  use bw_damping, only: damping_law
  use bw_forced_beam, only: forced_beam
  use bw_kinds, only: dp
  use bw_mode_set, only: damping_rates, mode_set
  use bw_response_extremes, only: harmonic_response
  use bw_scene, only: scene_type
  use bw_static_shape, only: deflection, static_shapes
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: chosen, terms_of

  real(dp), parameter :: off_axis = 0.01_dp !! tuned: of Ω², distance from the axis at which r is evaluated; its square is the error
  integer, parameter :: nodes = 4                    !! of the polynomial in s²

  type, public :: modal_terms
    !! The terms of a modal sum.
    real(dp), allocatable :: weight(:, :)            !! Φ_k(ξ)Φ_k(ξ_f)/M_k, (modes, points)
    real(dp), allocatable :: square(:)               !! β_k²
    real(dp), allocatable :: damping(:)              !! c_k
  end type modal_terms

  type, extends(harmonic_response), public :: modal_response
    !! Sums n modes and adds the correction for all others.
    type(modal_terms) :: own, plain                  !! of the beam, and of its uniform pieces without tension
    type(forced_beam) :: forced
    integer :: n = 0
    real(dp), allocatable :: grown(:, :)             !! responses to forces growing with s², 2s², …, (points, nodes); on a free hub
    real(dp) :: shift = 0.0_dp                       !! s²
    type(damping_law) :: law
    real(dp), allocatable :: rounding(:, :)          !! errors of β², and of M relatively, (modes, 2); with `grown`
  contains
    procedure :: at => sum_modes
    procedure :: let_grow
    procedure :: rounding_at
  end type modal_response

contains

  subroutine sum_modes(self, omega, point, value)
    class(modal_response), intent(inout) :: self
    real(dp), intent(in) :: omega
    integer, intent(in) :: point
    complex(dp), intent(out) :: value(:)
    value = sum_of(self%own, self%n, cmplx(omega**2, 0.0_dp, dp), omega, point)
    if (allocated(self%grown)) then
      value = value + rest_of_growth(self, omega, point)
    else
      value = value + rest_of(self%own, self%plain, self%n, omega, point, self%forced)
    end if
  end subroutine sum_modes

  type(modal_terms) function terms_of(scene, set) result(terms)
    !! Collect the terms of the modes of a set.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: set
    real(dp) :: forced(set%count, 2)
    integer :: p
    forced = set%motion_at(scene%frequency_response%position)
    terms%weight = set%shapes(scene%frequency_response%points)
    do p = 1, size(terms%weight, 2)
      terms%weight(:, p) = terms%weight(:, p)*forced(:, 1)/set%modal_mass(:set%count)
    end do
    terms%square = set%beta_squared(:set%count)%hi
    terms%damping = damping_rates(set)
  end function terms_of

  pure function sum_of(terms, n, square, omega, point) result(value)
    !! Sum the first n modes, at all points or at one.
    type(modal_terms), intent(in) :: terms
    integer, intent(in) :: n
    complex(dp), intent(in) :: square                !! Ω², or a complex value near it
    real(dp), intent(in) :: omega                    !! Ω of the damping term; 0: undamped
    integer, intent(in) :: point                     !! 0: all
    complex(dp) :: value(merge(1, size(terms%weight, 2), point > 0))
    associate (first => max(1, point))
      value = matmul(1.0_dp/(terms%square(:n) - square + cmplx(0.0_dp, terms%damping(:n)*omega, dp)), &
                     terms%weight(:n, first:first + size(value) - 1))
    end associate
  end function sum_of

  function rest_of(own, plain, n, omega, point, forced) result(rest)
    !! Return r for the first n modes, at all points or at one.
    type(modal_terms), intent(in) :: own, plain      !! of the beam, and of its uniform pieces without tension
    integer, intent(in) :: n, point
    real(dp), intent(in) :: omega
    type(forced_beam), intent(inout) :: forced
    complex(dp) :: rest(merge(1, size(own%weight, 2), point > 0)), square(2), whole(size(own%weight, 2))
    real(dp) :: damped
    integer :: i
    damped = own%damping(n)*omega
    square = cmplx(omega**2, [off_axis*omega**2, -2.0_dp*damped - off_axis*omega**2], dp)
    rest = 0.0_dp
    do i = 1, 2
      call forced%respond(square(i), (0.0_dp, 0.0_dp), whole)
      rest = rest + 0.5_dp*(chosen(whole, point) - sum_of(plain, n, square(i), 0.0_dp, point))
    end do
  end function rest_of

  subroutine let_grow(self, modes, given, position, points, highest)
    !! Find the responses to growing forces.
    class(modal_response), intent(inout) :: self
    class(mode_set), intent(in) :: modes
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: position, points(:)      !! ξ of the force and of the points
    real(dp), intent(in) :: highest                  !! largest Ω
    real(dp) :: shapes(size(points), 5, 1)
    integer :: i
    if (allocated(modes%law)) self%law = modes%law
    self%shift = max(0.25_dp*abs(node_at(self, modes%count, highest)), 2.0_dp*given%beam%spin_squared%hi + 0.25_dp)
    allocate (self%grown(size(points), nodes))
    do i = 1, nodes
      shapes = static_shapes(given, [position], .false., i*self%shift, points)
      self%grown(:, i) = shapes(:, deflection, 1)
    end do
    allocate (self%rounding(modes%count, 2))
    call modes%number_errors(self%rounding(:, 1), self%rounding(:, 2))
  end subroutine let_grow

  pure function rounding_at(self, omega) result(rounding)
    !! Return the effect of rounding in the modes on the response, (points); 0 unless r is exact to rounding.
    class(modal_response), intent(in) :: self
    real(dp), intent(in) :: omega
    real(dp) :: rounding(size(self%own%weight, 2)), away(size(self%own%square))
    rounding = 0.0_dp
    if (.not. allocated(self%rounding)) return
    away = abs(cmplx(self%own%square - omega**2, self%own%damping*omega, dp))
    rounding = matmul((self%rounding(:, 2) + self%rounding(:, 1)/away)/away, abs(self%own%weight))
  end function rounding_at

  pure function rest_of_growth(self, omega, point) result(rest)
    !! Return r on a free hub, at all points or at one.
    class(modal_response), intent(in) :: self
    real(dp), intent(in) :: omega
    integer, intent(in) :: point                     !! 0: all
    complex(dp) :: rest(merge(1, size(self%own%weight, 2), point > 0)), node, weight
    integer :: i, j
    node = node_at(self, self%n, omega)/self%shift
    rest = 0.0_dp
    do i = 1, nodes
      weight = product([((node - j)/(i - j), j=1, i - 1), ((node - j)/(i - j), j=i + 1, nodes)])
      rest = rest + weight*(chosen(cmplx(self%grown(:, i), 0.0_dp, dp), point) &
                            - sum_of(self%own, self%n, cmplx(-i*self%shift, 0.0_dp, dp), 0.0_dp, point))
    end do
    rest = rest/cmplx(1.0_dp, self%law%stiffness*omega, dp)
  end function rest_of_growth

  pure complex(dp) function node_at(self, n, omega) result(node)
    !! Return s² at which the response to a growing force is that at Ω.
    class(modal_response), intent(in) :: self
    integer, intent(in) :: n                         !! modes summed
    real(dp), intent(in) :: omega
    real(dp) :: rate
    rate = self%law%mass
    if (self%law%ratio > 0.0_dp) rate = self%own%damping(n)
    node = cmplx(-omega**2, rate*omega, dp)/cmplx(1.0_dp, self%law%stiffness*omega, dp)
  end function node_at

  pure function chosen(values, point) result(some)
    !! Return the value at one point, or all values.
    complex(dp), intent(in) :: values(:)
    integer, intent(in) :: point                     !! 0: all
    complex(dp), allocatable :: some(:)
    some = values
    if (point > 0) some = values(point:point)
  end function chosen

end module bw_modal_response

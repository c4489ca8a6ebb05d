module bw_beam_parts
  !! A beam cut into parts over which its state varies slowly, and the transfer matrix of each part by Gauss
  !! collocation, for motions that grow as e^(st) (bw_static_shape). Without dimensions, as the beam.
  !!
  !! The state z = (v, ψ, M, Q) obeys v' = (ψ + sQ)/(1 + sT), ψ' = M/B, M' = −Q + Tv' − Rψ, Q' = −mλv with
  !! λ = ω² − s² in the plane of rotation, else −s², and R likewise of rotary inertia.
  use bw_constants, only: pi
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_lapack, only: dgesv
  use bw_missing, only: no_number
  use bw_piece_beam, only: joint_position
  use bw_varying_beam, only: value_of, varying_beam
  implicit none (type, external)
  private
  public :: cut_parts, gauss_places

  integer, parameter :: stages = 8                !! of Gauss collocation; its order is twice that
  real(dp), parameter :: calm = 0.7_dp            !! limit of the change of the state over a part

  type, public :: beam_part
    !! A part of a piece.
    integer :: piece = 1
    real(dp) :: from = 0.0_dp, to = 1.0_dp        !! places over the piece
    logical :: ends_piece = .false.               !! the joint there comes after it
    real(dp) :: across(4, 4) = 0.0_dp             !! final state by initial state
  end type beam_part

contains

  pure subroutine cut_parts(given, shift, xi, parts, end_of)
    !! Cut the beam into parts that end at joints and at all points.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: shift, xi(:)
    type(beam_part), allocatable, intent(out) :: parts(:)
    integer, intent(out) :: end_of(:)             !! (points)
    real(dp), parameter :: same_place = 1.0e-13_dp
    real(dp), allocatable :: places(:)
    type(dd) :: start
    real(dp) :: length, x
    integer :: i, j, p
    allocate (parts(0), places(0))
    end_of = 0
    do i = 1, size(given%beam%piece)
      start = joint_position(given%beam, i - 1)
      length = given%beam%piece(i)%length%hi
      associate (many => parts_of(given, i, shift))
        places = [(real(j, dp)/many, j=1, many)]
      end associate
      do p = 1, size(xi)
        x = ((xi(p) - start%hi) - start%lo)/length
        if (x <= same_place .or. x >= 1.0_dp - same_place) cycle
        j = count(places < x - same_place)
        if (abs(places(j + 1) - x) > same_place) places = [places(:j), x, places(j + 1:)]
      end do
      do j = 1, size(places)
        x = 0.0_dp
        if (j > 1) x = places(j - 1)
        parts = [parts, beam_part(i, x, places(j), j == size(places))]
        parts(size(parts))%across = carried(given, shift, parts(size(parts)))
        where (abs(xi - start%hi - start%lo - places(j)*length) <= 2*same_place) end_of = size(parts)
      end do
    end do
  end subroutine cut_parts

  pure integer function parts_of(given, i, shift) result(parts)
    !! Return the number of parts of a piece.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: i                      !! the piece
    real(dp), intent(in) :: shift
    integer, parameter :: most = 4000
    real(dp) :: change, law, mass, pull, softest
    associate (piece => given%beam%piece(i), laws => given%law(i))
      law = shift + given%beam%spin_squared%hi
      softest = piece%stiffness%hi*max(minval(value_of(laws%stiffness, [0.0_dp, 0.5_dp, 1.0_dp])), 1.0e-6_dp)
      mass = piece%mass%hi*maxval(abs(value_of(laws%mass, [0.0_dp, 0.5_dp, 1.0_dp])))
      pull = 0.0_dp
      if (given%is_pulled) pull = given%beam%spin_squared%hi*maxval(abs(value_of(given%tension(i), [0.0_dp, 0.5_dp, 1.0_dp])))
      change = piece%length%hi*max(sqrt(sqrt(mass*law/softest)), sqrt((pull + piece%rotary%hi*law)/softest), &
                                   1.0e-30_dp)
      if (any([size(laws%stiffness), size(laws%mass), size(laws%shear), size(laws%rotary)] > 1)) change = max(change, 4.0_dp)
    end associate
    parts = min(most, 1 + int(change/calm))
  end function parts_of

  pure function carried(given, shift, part) result(across)
    !! Return the transfer matrix of a part.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: shift
    type(beam_part), intent(in) :: part
    real(dp) :: across(4, 4)
    real(dp) :: place(stages), weight(stages), a(stages, stages), system(4*stages, 4*stages), slopes(4*stages, 4)
    real(dp) :: law(4, 4, stages), length
    integer :: i, info, j, pivot(4*stages)
    call gauss_rule(place, weight, a)
    length = (part%to - part%from)*given%beam%piece(part%piece)%length%hi
    law = state_law(given, part%piece, shift, part%from + (part%to - part%from)*place)
    system = 0.0_dp
    do i = 1, stages
      do j = 1, stages
        system(4*i - 3:4*i, 4*j - 3:4*j) = -length*a(i, j)*law(:, :, i)
      end do
      slopes(4*i - 3:4*i, :) = law(:, :, i)
    end do
    do i = 1, 4*stages
      system(i, i) = system(i, i) + 1.0_dp
    end do
    call dgesv(4*stages, 4, system, 4*stages, pivot, slopes, 4*stages, info)
    if (info /= 0) slopes = no_number()             ! no mode is found with it
    across = 0.0_dp
    do i = 1, 4
      across(i, i) = 1.0_dp
    end do
    do i = 1, stages
      across = across + length*weight(i)*slopes(4*i - 3:4*i, :)
    end do
  end function carried

  pure function state_law(given, i, shift, x) result(law)
    !! Return the matrix of z' = law z at places over a piece, (4, 4, places).
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: i                      !! the piece
    real(dp), intent(in) :: shift, x(:)
    real(dp) :: law(4, 4, size(x))
    real(dp), dimension(size(x)) :: stiffness, mass, compliance, rotary, pull
    real(dp) :: lambda, rho
    integer :: j
    lambda = -shift
    rho = -shift
    if (given%beam%in_plane) then
      lambda = lambda + given%beam%spin_squared%hi
    else
      rho = rho + given%beam%spin_squared%hi
    end if
    associate (piece => given%beam%piece(i), laws => given%law(i))
      stiffness = piece%stiffness%hi*value_of(laws%stiffness, x)
      mass = piece%mass%hi*value_of(laws%mass, x)
      compliance = piece%compliance%hi/value_of(laws%shear, x)
      rotary = piece%rotary%hi*value_of(laws%rotary, x)
    end associate
    pull = 0.0_dp
    if (given%is_pulled) pull = given%beam%spin_squared%hi*value_of(given%tension(i), x)
    law = 0.0_dp
    do j = 1, size(x)
      law(1, 2, j) = 1.0_dp/(1.0_dp + compliance(j)*pull(j))
      law(1, 4, j) = compliance(j)*law(1, 2, j)
      law(2, 3, j) = 1.0_dp/stiffness(j)
      law(3, 2, j) = pull(j)*law(1, 2, j) - rotary(j)*rho
      law(3, 4, j) = pull(j)*law(1, 4, j) - 1.0_dp
      law(4, 1, j) = -mass(j)*lambda
    end do
  end function state_law

  pure subroutine gauss_places(place, weight)
    !! Return Gauss points on [0, 1] and their weights.
    real(dp), allocatable, intent(out) :: place(:), weight(:)
    real(dp) :: a(stages, stages)
    allocate (place(stages), weight(stages))
    call gauss_rule(place, weight, a)
  end subroutine gauss_places

  pure subroutine gauss_rule(place, weight, a)
    !! Return Gauss points on [0, 1], their weights, and the integrals of Lagrange polynomials up to each of them.
    real(dp), intent(out) :: place(stages), weight(stages), a(stages, stages)
    real(dp) :: p(0:stages), slope, x
    real(dp), dimension(stages, 0:stages - 1) :: legendre, integral    ! P_j(x_i), and from −1 to x_i on the scale of [0, 1]
    integer :: i, iteration, j
    do i = 1, stages
      x = -cos(pi*(i - 0.25_dp)/(stages + 0.5_dp))
      do iteration = 1, 8
        p(0) = 1.0_dp
        p(1) = x
        do j = 2, stages
          p(j) = ((2*j - 1)*x*p(j - 1) - (j - 1)*p(j - 2))/j
        end do
        slope = stages*(x*p(stages) - p(stages - 1))/(x**2 - 1.0_dp)
        x = x - p(stages)/slope
      end do
      place(i) = 0.5_dp*(1.0_dp + x)
      weight(i) = 1.0_dp/((1.0_dp - x**2)*slope**2)
      ! ∫_{-1}^{x} P_j = (P_{j+1} - P_{j-1})/(2j + 1)
      integral(i, 0) = 0.5_dp*(x + 1.0_dp)
      do j = 1, stages - 1
        integral(i, j) = 0.5_dp*(p(j + 1) - p(j - 1))/(2*j + 1)
      end do
      legendre(i, :) = p(:stages - 1)
    end do
    ! the rule integrates P_iP_j exactly, so that Lagrange's polynomial of x_k is w_k Σ_j (2j + 1)P_j(x_k)P_j
    do i = 1, stages
      a(i, :) = weight*matmul(legendre, [(2*j + 1, j=0, stages - 1)]*integral(i, :))
    end do
  end subroutine gauss_rule

end module bw_beam_parts

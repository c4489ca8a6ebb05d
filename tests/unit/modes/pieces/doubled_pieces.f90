module doubled_pieces
  !! How many modes of a beam of pieces lie below a frequency, in binary128 and by a way of its own: nothing of `src/modes/` is
  !! used.
  !!
  !! Half of a piece is cut in halves until its waves hardly turn in it. There the four motions that start in its middle are power
  !! series, and none is a mode of clamped ends. Two such elements make one twice as long: in its even motions the joint between
  !! them deflects without turning, in its odd ones it turns without deflecting, and letting it go adds a mode wherever its
  !! stiffness is negative (Wittrick and Williams 1971). What is left are the joints of the beam, whose matrix has as many negative
  !! pivots as modes are to be added.
  use bw_double_double, only: to_quad
  use bw_kinds, only: qp
  use bw_piece_beam, only: piece_beam, uniform_piece
  implicit none (type, external)
  private
  public :: modes_below

  integer, parameter :: terms = 24                   !! of series in |√z|x ≤ 1/8, beyond the 34th digit
  real(qp), parameter :: longest = 0.25_qp           !! |√z| times the length of the first element

  type :: element
    !! A length of beam between two ends.
    real(qp) :: even(2, 2), odd(2, 2)                !! forces N and M at the outer end for v and ψ there, in motions of one parity
    integer :: clamped = 0                           !! modes with both ends clamped below the frequency
  end type element

contains

  pure integer function modes_below(beam, lambda) result(number)
    type(piece_beam), intent(in) :: beam
    real(qp), intent(in) :: lambda                   !! λ
    real(qp) :: matrix(0:3, 2*size(beam%piece) + 2)  ! element (i, i + d) at (d, i): v and ψ of joints from the root outwards
    real(qp) :: spin, square
    type(element) :: whole
    integer :: i, n
    n = size(beam%piece)
    spin = to_quad(beam%spin_squared)
    square = merge(lambda - spin, lambda, beam%in_plane)
    matrix = 0.0_qp
    matrix(0, 1:2) = [to_quad(beam%root%stiffness), to_quad(beam%root%turning_stiffness)]
    number = 0
    do i = 1, n
      whole = element_of(beam%piece(i), lambda, merge(square, lambda + spin, beam%in_plane))
      number = number + whole%clamped
      call add_piece(whole, matrix(:, 2*i - 1:2*i + 2))
      associate (joint => beam%joint(i))
        matrix(0, 2*i + 1) = matrix(0, 2*i + 1) + to_quad(joint%stiffness) - to_quad(joint%mass)*lambda
        matrix(0, 2*i + 2) = matrix(0, 2*i + 2) + to_quad(joint%turning_stiffness) - to_quad(joint%inertia)*square
      end associate
    end do
    if (beam%root%holds_deflection) call hold(matrix, 1)
    if (beam%root%holds_turning) call hold(matrix, 2)
    number = number + negative_pivots(matrix)
  end function modes_below

  pure type(element) function element_of(piece, lambda, rho) result(whole)
    !! A piece, from an element that is short.
    type(uniform_piece), intent(in) :: piece
    real(qp), intent(in) :: lambda, rho              !! of what deflects, of sections that turn
    real(qp) :: b, c, wave, length
    integer :: doublings, i
    b = to_quad(piece%rotary)*rho/to_quad(piece%stiffness) + to_quad(piece%compliance)*to_quad(piece%mass)*lambda
    c = to_quad(piece%mass)*lambda/to_quad(piece%stiffness)*(1 - to_quad(piece%compliance)*to_quad(piece%rotary)*rho)
    wave = sqrt(0.5_qp*abs(b) + sqrt(0.25_qp*b**2 + abs(c)))
    length = to_quad(piece%length)
    doublings = max(0, exponent(wave*length/longest))
    whole = short_element(piece, lambda, rho, scale(length, -doublings))
    do i = 1, doublings
      whole = doubled(whole)
    end do
  end function element_of

  pure type(element) function short_element(piece, lambda, rho, length) result(short)
    !! By power series from its middle: v' = ψ + sN, ψ' = M/B, M' = −N − ρIρψ, N' = −ρAλv.
    type(uniform_piece), intent(in) :: piece
    real(qp), intent(in) :: lambda, rho, length
    real(qp) :: state(4, 4), term(4), next(4), inertia(2)
    integer :: j, m
    inertia = [to_quad(piece%mass)*lambda, to_quad(piece%rotary)*rho]
    state = 0.0_qp
    do j = 1, 4
      term = 0.0_qp
      term(j) = 1.0_qp
      do m = 1, terms
        state(:, j) = state(:, j) + term
        next(1) = term(2) + to_quad(piece%compliance)*term(4)
        next(2) = term(3)/to_quad(piece%stiffness)
        next(3) = -term(4) - inertia(2)*term(2)
        next(4) = -inertia(1)*term(1)
        term = next*(0.5_qp*length/m)
      end do
    end do
    short%even = stiffness_of(state(:, [1, 3]))      ! from v and from M: v is even
    short%odd = stiffness_of(state(:, [2, 4]))       ! from ψ and from N
  end function short_element

  pure function stiffness_of(state) result(k)
    !! Forces N and M for v and ψ, of two motions (v, ψ, M, N).
    real(qp), intent(in) :: state(4, 2)
    real(qp) :: k(2, 2)
    real(qp) :: det
    det = state(1, 1)*state(2, 2) - state(1, 2)*state(2, 1)
    k(:, 1) = (state([4, 3], 1)*state(2, 2) - state([4, 3], 2)*state(2, 1))/det
    k(:, 2) = (state([4, 3], 2)*state(1, 1) - state([4, 3], 1)*state(1, 2))/det
  end function stiffness_of

  pure type(element) function doubled(one) result(two)
    !! Two elements, one after the other.
    type(element), intent(in) :: one
    real(qp) :: own(2, 2), link(2, 2)
    own = 0.5_qp*(one%even + one%odd)
    link = 0.5_qp*(one%even - one%odd)
    two%even = own - by_product(link(:, 1), own(1, 1))
    two%odd = own - by_product(link(:, 2), own(2, 2))
    two%clamped = 2*one%clamped + count([own(1, 1), own(2, 2)] < 0.0_qp)
  end function doubled

  pure function by_product(link, pivot) result(change)
    !! What letting go of a motion takes from the stiffness.
    real(qp), intent(in) :: link(2), pivot
    real(qp) :: change(2, 2)
    real(qp) :: share(2)
    share = link/merge(pivot, tiny(pivot)**0.25_qp, pivot /= 0.0_qp)
    change(:, 1) = link*share(1)
    change(:, 2) = link*share(2)
  end function by_product

  pure subroutine add_piece(whole, matrix)
    !! To the rows of v and ψ at its inner and its outer end.
    type(element), intent(in) :: whole
    real(qp), intent(inout) :: matrix(0:3, 4)
    real(qp) :: own(2, 2), link(2, 2)
    own = 0.5_qp*(whole%even + whole%odd)
    link = 0.5_qp*(whole%even - whole%odd)
    link(:, 2) = -link(:, 2)                         ! to the turning at the inner end, which has the other sign there
    matrix(0, :) = matrix(0, :) + [own(1, 1), own(2, 2), own(1, 1), own(2, 2)]
    matrix(1, [1, 3]) = matrix(1, [1, 3]) + [-own(1, 2), own(1, 2)]
    matrix(2, 1) = matrix(2, 1) + link(1, 1)
    matrix(3, 1) = matrix(3, 1) + link(2, 1)
    matrix(1, 2) = matrix(1, 2) + link(1, 2)
    matrix(2, 2) = matrix(2, 2) + link(2, 2)
  end subroutine add_piece

  pure subroutine hold(matrix, i)
    !! What is held takes part no more.
    real(qp), intent(inout) :: matrix(0:, :)
    integer, intent(in) :: i
    integer :: d
    matrix(1:, i) = 0.0_qp
    matrix(0, i) = 1.0_qp
    do d = 1, i - 1
      matrix(d, i - d) = 0.0_qp
    end do
  end subroutine hold

  pure integer function negative_pivots(given) result(number)
    real(qp), intent(in) :: given(0:, :)
    real(qp) :: matrix(0:3, size(given, 2)), pivot, share
    integer :: d, i
    matrix = given
    number = 0
    do i = 1, size(matrix, 2)
      pivot = matrix(0, i)
      if (pivot < 0.0_qp) number = number + 1
      if (pivot == 0.0_qp) pivot = tiny(pivot)**0.25_qp
      do d = 1, min(3, size(matrix, 2) - i)
        share = matrix(d, i)/pivot
        matrix(0:3 - d, i + d) = matrix(0:3 - d, i + d) - share*matrix(d:3, i)
      end do
    end do
  end function negative_pivots

end module doubled_pieces

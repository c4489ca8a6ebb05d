module bw_far_field
  !! The far-field part of Σ_k w_k/(α_i⁴ − ᾱ_k⁴), in time proportional to the number of modes: a fast multipole method
  !! in one dimension.
  !!
  !! Mode k has its root in π(k − 1, k), with or without the mass, so cells of `leaf` mode numbers are cells of roots. Cells of
  !! the next level hold two of them, and so on up to two cells. For two cells of a level that do not touch, 1/(α⁴ − ᾱ⁴) is
  !! smooth in both roots and replaced by its Chebyshev interpolant: weights are passed to the nodes of their cells and upwards
  !! through the levels; nodes interact with those of cells that do not touch theirs while their parents do; sums are passed
  !! downwards. A singularity is at least three half-widths from the middle of a cell, so the error falls as (3 + √8)^(−nodes).
  !!
  !! Positions are in units of π from the middle of their cell, so their differences lose no digits for high mode numbers.
  !!
  !! **Source**: Fong & Darve (2009), doi:10.1016/j.jcp.2009.08.031.
  use bw_constants, only: pi, qp_pi
  use bw_frequency_equation, only: root_type
  use bw_kinds, only: dp, qp
  use bw_monitor, only: between_questions, monitor_type, stops
  implicit none (type, external)
  private
  public :: add_far_field, cells_to, first_in_cells

  integer, parameter :: leaf = 64                   !! tuned: mode numbers in a cell of the lowest level
  integer, parameter :: nodes = 20                  !! (3 + √8)^(−20) is 5e-16

  type :: level_type
    real(dp), allocatable :: node(:, :)             !! weights, or sums, at the nodes, (nodes, cells)
  end type level_type

  type :: interpolation
    !! S(x, t) = 1/n + 2/n Σ T_j(x)T_j(t) passes a weight at t to the node x, and a value at x to t.
    real(dp) :: place(nodes)                        !! nodes, −1 … 1
    real(dp) :: series(nodes, 0:nodes - 1)          !! S in T_j(t), (nodes, degrees)
    real(dp) :: halves(nodes, nodes, 2)             !! S between the nodes of a cell and those of its halves
  end type interpolation

contains

  subroutine add_far_field(onto, from, weight, sums, monitor)
    !! Add the terms of all pairs in cells that do not touch.
    type(root_type), intent(in) :: onto(:), from(:) !! i and k, ascending
    real(dp), intent(in) :: weight(:)               !! w_k, (size(from))
    real(dp), intent(inout) :: sums(:)              !! (size(onto))
    class(monitor_type), intent(inout), optional :: monitor   !! the sums are invalid if it requests a stop
    type(interpolation) :: chebyshev
    type(level_type), allocatable :: weights(:)
    real(dp), allocatable :: field(:, :)
    integer :: cells, level, top
    chebyshev = interpolation_of_cells()
    cells = max(cells_to(onto), cells_to(from))
    top = 0
    do while (cells > 2*2**top)
      top = top + 1
    end do
    allocate (weights(0:top))
    weights(0)%node = gathered(chebyshev, from, weight, monitor)
    do level = 1, top
      weights(level)%node = lifted(chebyshev, weights(level - 1)%node)
    end do
    allocate (field(nodes, 2), source=0.0_dp)
    cells = cells_to(onto)
    do level = top, 0, -1
      if (stops(monitor)) return
      field = lowered(chebyshev, field, (cells - 1)/2**level + 1)
      call exchange(chebyshev, leaf*2.0_dp**level, weights(level)%node, field, monitor)
    end do
    call scatter(chebyshev, onto, field, sums, monitor)
  end subroutine add_far_field

  pure integer function cells_to(roots) result(cells)
    !! Count the cells that hold all these modes.
    type(root_type), intent(in) :: roots(:)         !! ascending
    cells = (roots(size(roots))%k - 1)/leaf + 1
  end function cells_to

  pure function first_in_cells(roots, cells) result(first)
    !! Return the index of the first root of each cell, and one beyond the last root, (cells + 1).
    type(root_type), intent(in) :: roots(:)         !! ascending
    integer, intent(in) :: cells
    integer :: first(cells + 1)
    integer :: c, i
    i = 1
    do c = 1, cells
      first(c) = i
      do while (i <= size(roots))
        if (roots(i)%k > c*leaf) exit
        i = i + 1
      end do
    end do
    first(cells + 1) = i
  end function first_in_cells

  pure type(interpolation) function interpolation_of_cells() result(chebyshev)
    !! Return the interpolation constants, from extended precision, so that rounding does not accumulate over levels.
    real(qp) :: place(nodes), series(nodes, 0:nodes - 1), half_place(nodes)
    integer :: half, j, m
    associate (angle => [((2*m - 1)*qp_pi/(2*nodes), m=1, nodes)])
      place = cos(angle)
      do j = 0, nodes - 1
        series(:, j) = cos(j*angle)*(merge(1.0_qp, 2.0_qp, j == 0)/nodes)
      end do
      do half = 1, 2
        half_place = acos(0.5_qp*(place + (2*half - 3)))
        do m = 1, nodes
          chebyshev%halves(:, m, half) = real(matmul(series, [(cos(j*half_place(m)), j=0, nodes - 1)]), dp)
        end do
      end do
    end associate
    chebyshev%place = real(place, dp)
    chebyshev%series = real(series, dp)
  end function interpolation_of_cells

  pure function chebyshev_polynomials(t) result(values)
    !! Return T_j(t), (positions, degrees).
    real(dp), intent(in) :: t(:)
    real(dp) :: values(size(t), 0:nodes - 1)
    integer :: j
    values(:, 0) = 1.0_dp
    values(:, 1) = t
    do j = 2, nodes - 1
      values(:, j) = 2.0_dp*t*values(:, j - 1) - values(:, j - 2)
    end do
  end function chebyshev_polynomials

  elemental real(dp) function place_in_cell(root, cell) result(t)
    !! Return the position of a root in its cell, −1 … 1, from its eighths of a cycle and remainder.
    type(root_type), intent(in) :: root
    integer, intent(in) :: cell
    t = (0.25_dp*(root%eighths - (4*cell - 2)*leaf) + root%remainder/pi)*(2.0_dp/leaf)
  end function place_in_cell

  function gathered(chebyshev, from, weight, monitor) result(node)
    !! Return weights of modes as weights at the nodes of their cells, (nodes, cells).
    type(interpolation), intent(in) :: chebyshev
    type(root_type), intent(in) :: from(:)
    real(dp), intent(in) :: weight(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: node(nodes, cells_to(from))
    integer :: first(size(node, 2) + 1), c
    first = first_in_cells(from, size(node, 2))
    node = 0.0_dp
    do c = 1, size(node, 2)
      if (mod(c, between_questions) == 0) then
        if (stops(monitor)) return
      end if
      associate (i => first(c), j => first(c + 1) - 1)
        node(:, c) = matmul(chebyshev%series, matmul(weight(i:j), chebyshev_polynomials(place_in_cell(from(i:j), c))))
      end associate
    end do
  end function gathered

  pure function lifted(chebyshev, node) result(above)
    !! Return weights at the nodes of cells as weights at the nodes of their parents, (nodes, cells).
    type(interpolation), intent(in) :: chebyshev
    real(dp), intent(in) :: node(:, :)
    real(dp) :: above(nodes, (size(node, 2) + 1)/2)
    integer :: c
    above = 0.0_dp
    do c = 1, size(node, 2)
      associate (whole => above(:, (c + 1)/2))
        whole = whole + matmul(chebyshev%halves(:, :, 2 - mod(c, 2)), node(:, c))
      end associate
    end do
  end function lifted

  pure function lowered(chebyshev, above, cells) result(node)
    !! Return sums at the nodes of cells as sums at the nodes of their halves, (nodes, cells).
    type(interpolation), intent(in) :: chebyshev
    real(dp), intent(in) :: above(:, :)
    integer, intent(in) :: cells
    real(dp) :: node(nodes, cells)
    integer :: c
    do c = 1, cells
      node(:, c) = matmul(above(:, (c + 1)/2), chebyshev%halves(:, :, 2 - mod(c, 2)))
    end do
  end function lowered

  subroutine exchange(chebyshev, width, weights, field, monitor)
    !! Add interactions between cells of a level that do not touch while their parents do.
    type(interpolation), intent(in) :: chebyshev
    real(dp), intent(in) :: width                   !! of a cell, in units of π
    real(dp), intent(in) :: weights(:, :)
    real(dp), intent(inout) :: field(:, :)
    class(monitor_type), intent(inout), optional :: monitor
    integer :: c, other, parent
    do c = 1, size(field, 2)
      if (mod(c, between_questions) == 0) then
        if (stops(monitor)) return
      end if
      parent = (c + 1)/2
      do other = max(1, 2*parent - 3), min(size(weights, 2), 2*parent + 2)
        if (abs(other - c) > 1) call interact(chebyshev, width, other, weights(:, other), c, field(:, c))
      end do
    end do
  end subroutine exchange

  pure subroutine interact(chebyshev, width, from, weights, onto, field)
    !! Add to the nodes of one cell the weights at those of another, times 1/(u⁴ − v⁴) in units of π⁻⁴.
    type(interpolation), intent(in) :: chebyshev
    real(dp), intent(in) :: width
    integer, intent(in) :: from, onto               !! cells
    real(dp), intent(in) :: weights(:)
    real(dp), intent(inout) :: field(:)
    real(dp) :: u(nodes), v
    integer :: j
    u = width*((onto - 0.5_dp) + 0.5_dp*chebyshev%place)
    do j = 1, nodes
      v = width*((from - 0.5_dp) + 0.5_dp*chebyshev%place(j))
      field = field + weights(j)/pi**4/((width*((onto - from) + 0.5_dp*(chebyshev%place - chebyshev%place(j)))) &
                                        *(u + v)*(u**2 + v**2))
    end do
  end subroutine interact

  subroutine scatter(chebyshev, onto, node, sums, monitor)
    !! Add sums at the nodes of cells to those of their modes.
    type(interpolation), intent(in) :: chebyshev
    type(root_type), intent(in) :: onto(:)
    real(dp), intent(in) :: node(:, :)
    real(dp), intent(inout) :: sums(:)
    class(monitor_type), intent(inout), optional :: monitor
    integer :: first(cells_to(onto) + 1), c
    first = first_in_cells(onto, cells_to(onto))
    do c = 1, size(node, 2)
      if (mod(c, between_questions) == 0) then
        if (stops(monitor)) return
      end if
      associate (i => first(c), j => first(c + 1) - 1)
        sums(i:j) = sums(i:j) + matmul(chebyshev_polynomials(place_in_cell(onto(i:j), c)), matmul(node(:, c), chebyshev%series))
      end associate
    end do
  end subroutine scatter

end module bw_far_field

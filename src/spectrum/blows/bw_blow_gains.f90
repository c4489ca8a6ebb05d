module bw_blow_gains
  !! Gains of new motion with known poles, at each sample where it may begin or end.
  !!
  !! Motion that begins at sample n lowers the squares of the residual by T(n) = cᵀG⁻¹c. Here c is the residual's scalar products
  !! with the parts of Σ e^(z_k(m − n)), m ≥ n, and G those of these parts. Both follow from those for n + 1, so that all n together
  !! cost no more than a few transforms.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: gain_of_jump, gains_before, gains_from, is_sudden

  integer, parameter :: renewed = 100            !! G is renewed when its samples have grown by 1/renewed
  integer, parameter :: most_cells = 4           !! on either side of a sample
  integer, parameter :: rows_per_column = 2      !! rows of a cell, at least; more would exclude blows close to each other
  real(dp), parameter :: smooth = 0.05_dp        !! tuned: a ramp leaves 0.31 of what a jump at n explains, a random walk more
  real(dp), parameter :: ridge = 1.0e-6_dp       !! of G's diagonal, needed if poles are close to each other

contains

  pure function gains_from(poles, values) result(gain)
    !! The gains of motion that begins at each sample, (N), in variances of the noise.
    complex(dp), intent(in) :: poles(:)          !! per step
    real(dp), intent(in) :: values(:, :)         !! white, (N, S)
    real(dp) :: gain(size(values, 1))
    complex(dp), dimension(size(poles), size(poles)) :: with, against, product, mirrored
    complex(dp) :: c(size(poles), size(values, 2)), step(size(poles))
    real(dp) :: factor(2*size(poles), 2*size(poles)), y(2*size(poles))
    integer :: n, k, s, rows, next
    step = exp(poles)
    do k = 1, size(poles)
      with(:, k) = exp(poles + poles(k))
      against(:, k) = exp(poles + conjg(poles(k)))
    end do
    product = 0
    mirrored = 0
    c = 0
    gain = 0
    next = 0
    do n = size(values, 1), 1, -1
      product = 1 + with*product
      mirrored = 1 + against*mirrored
      do s = 1, size(values, 2)
        c(:, s) = values(n, s) + step*c(:, s)
      end do
      rows = size(values, 1) - n + 1
      if (rows < 2*size(y)) cycle
      if (rows >= next .or. n == 1) then
        factor = inverse_triangle(product, mirrored)
        next = rows + rows/renewed + 1
      end if
      do s = 1, size(values, 2)
        y = matmul([c(:, s)%re, -c(:, s)%im], factor)
        gain(n) = gain(n) + dot_product(y, y)
      end do
    end do
  end function gains_from

  pure function gains_before(poles, values) result(gain)
    !! The gains of motion that ends before each sample, (N), in variances of the noise.
    complex(dp), intent(in) :: poles(:)          !! per step
    real(dp), intent(in) :: values(:, :)         !! white, (N, S)
    real(dp) :: gain(size(values, 1))
    complex(dp), dimension(size(poles), size(poles)) :: product, mirrored
    complex(dp) :: c(size(poles), size(values, 2)), wave(size(poles)), step(size(poles))
    real(dp) :: factor(2*size(poles), 2*size(poles)), y(2*size(poles))
    integer :: n, k, s, next
    product = 0
    mirrored = 0
    c = 0
    gain = 0
    wave = 1
    step = exp(poles)
    next = 2*size(y) + 1
    do n = 1, size(values, 1)
      if (n >= next) then
        factor = inverse_triangle(product, mirrored)
        next = n + n/renewed + 1
      end if
      do s = 1, size(values, 2)
        if (n > 2*size(y)) then
          y = matmul([c(:, s)%re, -c(:, s)%im], factor)
          gain(n) = gain(n) + dot_product(y, y)
        end if
        c(:, s) = c(:, s) + values(n, s)*wave
      end do
      do k = 1, size(poles)
        product(:, k) = product(:, k) + wave*wave(k)
        mirrored(:, k) = mirrored(:, k) + wave*conjg(wave(k))
      end do
      wave = wave*step
    end do
  end function gains_before

  pure logical function is_sudden(poles, values, n, need)
    !! Whether the amplitudes change at sample n rather than gradually. In some window around it, amplitudes of their own
    !! before and from n on then gain more than `need`, and others in parts of both sides hardly more. What lines do not
    !! describe (two modes in one, a stiffness that depends on the amplitude, a phase that wanders) changes them within a side, too.
    complex(dp), intent(in) :: poles(:)          !! per step
    real(dp), intent(in) :: values(:, :)         !! white, (N, S)
    integer, intent(in) :: n
    real(dp), intent(in) :: need                 !! in variances of the noise
    real(dp) :: gain(2), chance
    integer :: half, first, last, cells(2)
    is_sudden = .false.
    half = max(n - 1, size(values, 1) - n + 1)
    do
      first = max(1, n - half)
      last = min(size(values, 1), n + half - 1)
      cells = min(most_cells, [n - first, last - n + 1]/(rows_per_column*2*size(poles)))
      if (any(cells < 1) .or. sum(cells) < most_cells) return
      gain = gains_of_change(poles, values(first:last, :), n - first, cells)
      if (gain(1) < need) return
      chance = sqrt(real(2*sum(cells - 1)*2*size(poles)*size(values, 2), dp))  ! standard deviation of gain(2) in noise
      is_sudden = gain(2) + chance < smooth*gain(1)
      if (is_sudden) return
      half = half/2
    end do
  end function is_sudden

  pure real(dp) function gain_of_jump(poles, values, before) result(gain)
    !! What lines gain by amplitudes that change after so many samples; with none before, by amplitudes other than 0.
    complex(dp), intent(in) :: poles(:)          !! per step
    real(dp), intent(in) :: values(:, :)         !! white, (N, S)
    integer, intent(in) :: before
    complex(dp) :: wave(size(poles))
    real(dp), dimension(2*size(poles), 2*size(poles), 2) :: gram
    real(dp), dimension(2*size(poles), size(values, 2), 2) :: products
    wave = 1
    call multiply(exp(poles), values(:before, :), wave, gram(:, :, 1), products(:, :, 1))
    call multiply(exp(poles), values(before + 1:, :), wave, gram(:, :, 2), products(:, :, 2))
    gain = explained(gram(:, :, 2), products(:, :, 2))
    if (before > 0) gain = gain + explained(gram(:, :, 1), products(:, :, 1)) - explained(sum(gram, dim=3), sum(products, dim=3))
  end function gain_of_jump

  pure subroutine multiply(step, values, wave, gram, products)
    !! Find the scalar products of exponentials with each other and with consecutive samples.
    complex(dp), intent(in) :: step(:)           !! their factors from one sample to the next
    real(dp), intent(in) :: values(:, :)         !! white, (rows, S)
    complex(dp), intent(inout) :: wave(:)        !! their values at the first sample; on return those after the last
    real(dp), intent(out) :: gram(:, :), products(:, :)
    integer, parameter :: chunk = 1024           ! rows that fit a processor's cache
    real(dp) :: x(2*size(step), chunk)
    integer :: first, row, rows
    gram = 0
    products = 0
    do first = 1, size(values, 1), chunk
      rows = min(chunk, size(values, 1) - first + 1)
      do row = 1, rows
        x(:, row) = [wave%re, -wave%im]
        wave = wave*step
      end do
      gram = gram + matmul(x(:, :rows), transpose(x(:, :rows)))
      products = products + matmul(x(:, :rows), values(first:first + rows - 1, :))
    end do
  end subroutine multiply

  pure function gains_of_change(poles, values, before, cells) result(gain)
    !! What lines gain by amplitudes that change after so many samples, and more by others in each cell than by chance.
    complex(dp), intent(in) :: poles(:)
    real(dp), intent(in) :: values(:, :)
    integer, intent(in) :: before
    integer, intent(in) :: cells(2)              !! on either side
    real(dp) :: gain(2)
    complex(dp) :: wave(size(poles))
    real(dp), dimension(2*size(poles), 2*size(poles)) :: gram_all, gram_side, gram
    real(dp), dimension(2*size(poles), size(values, 2)) :: products_all, products_side, products
    integer :: edges(0:sum(cells)), side, cell, i
    edges = [(before*i/cells(1), i=0, cells(1)), (before + (size(values, 1) - before)*i/cells(2), i=1, cells(2))]
    gain = 0
    gram_all = 0
    products_all = 0
    wave = 1
    do side = 1, 2
      gram_side = 0
      products_side = 0
      do cell = merge(1, cells(1) + 1, side == 1), sum(cells(:side))
        call multiply(exp(poles), values(edges(cell - 1) + 1:edges(cell), :), wave, gram, products)
        gain(2) = gain(2) + explained(gram, products) - size(products)
        gram_side = gram_side + gram
        products_side = products_side + products
      end do
      gain = gain + [1, -1]*(explained(gram_side, products_side) - size(products))
      gram_all = gram_all + gram_side
      products_all = products_all + products_side
    end do
    gain(1) = gain(1) - explained(gram_all, products_all) + size(products)
  end function gains_of_change

  pure real(dp) function explained(gram, products)
    !! The squares that vectors explain, from their scalar products with each other and with the data.
    real(dp), intent(in) :: gram(:, :), products(:, :)
    explained = sum(matmul(transpose(orthonormal(gram)), products)**2)
  end function explained

  pure function inverse_triangle(product, mirrored) result(inverse)
    !! R⁻¹ for the scalar products RᵀR of real and negative imaginary parts of exponentials x, from Σ x_k x_l and Σ x_k x_l*.
    complex(dp), intent(in) :: product(:, :), mirrored(:, :)
    real(dp), dimension(2*size(product, 1), 2*size(product, 1)) :: gram, inverse
    integer :: n
    n = size(product, 1)
    gram(:n, :n) = real(mirrored + product, dp)/2
    gram(:n, n + 1:) = aimag(mirrored - product)/2
    gram(n + 1:, :n) = transpose(gram(:n, n + 1:))
    gram(n + 1:, n + 1:) = real(mirrored - product, dp)/2
    inverse = orthonormal(gram)
  end function inverse_triangle

  pure function orthonormal(gram) result(inverse)
    !! R⁻¹ for scalar products RᵀR, by Gram and Schmidt: the combinations of vectors that are orthonormal.
    real(dp), intent(in) :: gram(:, :)
    real(dp), dimension(size(gram, 1), size(gram, 1)) :: product, inverse
    integer :: i
    product = gram
    do i = 1, size(gram, 1)
      product(i, i) = gram(i, i)*(1 + ridge) + tiny(1.0_dp)
    end do
    inverse = 0
    do i = 1, size(gram, 1)
      inverse(i, i) = 1
      inverse(:, i) = inverse(:, i) - matmul(inverse(:, :i - 1), matmul(product(i, :), inverse(:, :i - 1)))
      inverse(:, i) = inverse(:, i)/sqrt(max(dot_product(inverse(:, i), matmul(product, inverse(:, i))), ridge*product(i, i)))
    end do
  end function orthonormal

end module bw_blow_gains

module bw_modal_sum
  !! Histories of stable modes, \( v(\xi,t) = \sum_k \Phi_k(\xi)\,[q_k\cos\beta_k t + \dot q_k \sin\beta_k t/\beta_k] \),
  !! Eq. 29, by products of matrices.
  !!
  !! Time is cut into blocks. The modal state at a block's start follows from a phase that is reduced modulo 2π
  !! before it is rounded; within the block every mode turns alike, so all samples of all blocks are one product of
  !! the table of turns with the table of states. Nothing is carried from sample to sample: no error grows with time.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, sqrt, operator(*), operator(/)
  use bw_monitor, only: monitor_type
  use bw_time_grid, only: time_grid
  use bw_turn, only: turns
  implicit none (type, external)
  private
  public :: add_stable_modes, block_length

  integer, parameter :: chunk_blocks = 32     !! tuned: the product's right side stays in the cache

  interface
    pure subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      !! BLAS: C = alpha·AB + beta·C
      import :: dp
      implicit none (type, external)
      character, intent(in) :: transa, transb
      integer, intent(in) :: m, n, k, lda, ldb, ldc
      real(dp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
      real(dp), intent(inout) :: c(ldc, *)
    end subroutine dgemm
  end interface

contains

  subroutine add_stable_modes(beta_squared, q, q_dot, shapes, grid, monitor, displacement, velocity)
    !! Adds the motion that starts from the modal state (q, q_dot) at t = 0; leaves early if the monitor asks for it.
    type(dd), intent(in) :: beta_squared(:)         !! β² > 0, (modes)
    real(dp), intent(in) :: q(:), q_dot(:)          !! modal displacements and velocities at t = 0, (modes)
    real(dp), intent(in) :: shapes(:, :)            !! Φ_k(ξ_p), (modes, points)
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    real(dp), intent(inout), contiguous :: displacement(:, :)   !! (samples, points)
    real(dp), intent(inout), optional, contiguous :: velocity(:, :)
    type(dd) :: beta(size(q)), cycles(size(q))
    real(dp) :: turn(block_length(grid%samples), 2*size(q))
    real(dp), allocatable :: turn_rate(:, :)
    real(dp), dimension(chunk_blocks, size(q)) :: state, state_dot
    real(dp) :: right(chunk_blocks, 2*size(q))
    integer :: first, blocks, length, p
    length = size(turn, 1)
    if (size(q) == 0) return
    beta = sqrt(beta_squared)
    cycles = beta*(grid%step/(dd_pi*2.0_dp))
    allocate (turn_rate(length, merge(2*size(q), 0, present(velocity))))
    call turns_in_block(beta%hi, cycles, turn, turn_rate)
    do first = 0, grid%samples - 1, length*chunk_blocks
      blocks = min(chunk_blocks, (grid%samples - first + length - 1)/length)
      call states_at_blocks(first, length, beta%hi, cycles, q, q_dot, state(:blocks, :), state_dot(:blocks, :))
      do p = 1, size(shapes, 2)
        call set_right(shapes(:, p), state(:blocks, :), state_dot(:blocks, :), right)
        call add_product(turn, right, blocks, first, displacement(:, p))
        if (present(velocity)) call add_product(turn_rate, right, blocks, first, velocity(:, p))
      end do
      call monitor%advance(real(first, dp)/grid%samples)
      if (monitor%stop_requested()) return
    end do
  end subroutine add_stable_modes

  pure integer function block_length(samples) result(length)
    !! A power of two near √samples: the two tables of turns together are smallest there.
    integer, intent(in) :: samples
    length = 2**min(8, max(3, nint(0.5_dp*log(real(samples, dp))/log(2.0_dp))))
  end function block_length

  pure subroutine turns_in_block(beta, cycles, turn, turn_rate)
    !! Rows: samples of a block. Columns: C_k then S_k for displacements, −β²S_k then C_k for velocities (none where no
    !! velocities are asked for).
    real(dp), intent(in) :: beta(:)
    type(dd), intent(in) :: cycles(:)
    real(dp), intent(out) :: turn(:, :), turn_rate(:, :)
    real(dp), dimension(size(turn, 1)) :: c, s
    integer :: k, n
    n = size(beta)
    do k = 1, n
      call turns(cycles(k), 0, 1, c, s)
      turn(:, k) = c
      turn(:, n + k) = s/beta(k)
      if (size(turn_rate, 2) == 0) cycle
      turn_rate(:, k) = -beta(k)*s
      turn_rate(:, n + k) = c
    end do
  end subroutine turns_in_block

  pure subroutine states_at_blocks(first, length, beta, cycles, q, q_dot, state, state_dot)
    !! Modal state at the first sample of each block.
    integer, intent(in) :: first, length    !! samples before the first block, and in each
    real(dp), intent(in) :: beta(:), q(:), q_dot(:)
    type(dd), intent(in) :: cycles(:)
    real(dp), intent(out) :: state(:, :), state_dot(:, :)   !! (blocks, modes)
    real(dp), dimension(size(state, 1)) :: c, s
    integer :: k
    do k = 1, size(q)
      call turns(cycles(k), first, length, c, s)
      state(:, k) = q(k)*c + (q_dot(k)/beta(k))*s
      state_dot(:, k) = q_dot(k)*c - (beta(k)*q(k))*s
    end do
  end subroutine states_at_blocks

  pure subroutine set_right(shape, state, state_dot, right)
    !! The right side of the product for one point.
    real(dp), intent(in) :: shape(:)
    real(dp), intent(in) :: state(:, :), state_dot(:, :)
    real(dp), intent(inout) :: right(:, :)
    integer :: blocks, k, n
    blocks = size(state, 1)
    n = size(shape)
    do k = 1, n
      right(:blocks, k) = shape(k)*state(:, k)
      right(:blocks, n + k) = shape(k)*state_dot(:, k)
    end do
  end subroutine set_right

  pure subroutine add_product(left, right, blocks, first, history)
    !! The product's columns are the blocks one after another: all but a last one that is cut short are added in place.
    real(dp), intent(in), contiguous :: left(:, :)    !! (samples of a block, terms)
    real(dp), intent(in), contiguous :: right(:, :)   !! (blocks and more, terms)
    integer, intent(in) :: blocks
    integer, intent(in) :: first                      !! samples before the first of the product
    real(dp), intent(inout), contiguous :: history(:)
    real(dp) :: last(size(left, 1))
    integer :: length, rest, terms, whole
    length = size(left, 1)
    terms = size(left, 2)
    whole = min(blocks, (size(history) - first)/length)
    if (whole > 0) call dgemm('N', 'T', length, whole, terms, 1.0_dp, left, length, right, size(right, 1), 1.0_dp, &
                              history(first + 1:first + length*whole), length)
    if (whole == blocks) return
    last = matmul(left, right(blocks, :))
    rest = size(history) - first - length*whole
    history(size(history) - rest + 1:) = history(size(history) - rest + 1:) + last(:rest)
  end subroutine add_product

end module bw_modal_sum

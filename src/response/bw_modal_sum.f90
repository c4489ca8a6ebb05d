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
  use bw_turn, only: phase_angles
  implicit none (type, external)
  private
  public :: add_stable_modes

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
    real(dp), dimension(block_length(grid%samples), 2*size(q)) :: turn, turn_rate
    real(dp), dimension(size(q), chunk_blocks) :: state, state_dot
    real(dp) :: right(2*size(q), chunk_blocks)
    integer :: b, first, blocks, length, n, p
    n = size(q)
    length = size(turn, 1)
    if (n == 0) return
    beta = sqrt(beta_squared)
    cycles = beta*(grid%step/(dd_pi*2.0_dp))
    call turns_in_block(beta%hi, cycles, turn, turn_rate)
    do first = 0, grid%samples - 1, length*chunk_blocks
      blocks = min(chunk_blocks, (grid%samples - first + length - 1)/length)
      call states_at_blocks([(first + b*length, b=0, blocks - 1)], beta%hi, cycles, q, q_dot, state, state_dot)
      do p = 1, size(shapes, 2)
        right(:n, :blocks) = spread(shapes(:, p), 2, blocks)*state(:, :blocks)
        right(n + 1:, :blocks) = spread(shapes(:, p), 2, blocks)*state_dot(:, :blocks)
        call add_product(turn, right(:, :blocks), first, displacement(:, p))
        if (present(velocity)) call add_product(turn_rate, right(:, :blocks), first, velocity(:, p))
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
    !! Rows: samples of a block. Columns: C_k then S_k for displacements, −β²S_k then C_k for velocities.
    real(dp), intent(in) :: beta(:)
    type(dd), intent(in) :: cycles(:)
    real(dp), intent(out) :: turn(:, :), turn_rate(:, :)
    real(dp), dimension(size(beta)) :: angle, c, s
    integer :: j, n
    n = size(beta)
    do j = 1, size(turn, 1)
      angle = phase_angles(cycles, j - 1)
      c = cos(angle)
      s = sin(angle)
      turn(j, :n) = c
      turn(j, n + 1:) = s/beta
      turn_rate(j, :n) = -beta*s
      turn_rate(j, n + 1:) = c
    end do
  end subroutine turns_in_block

  pure subroutine states_at_blocks(start, beta, cycles, q, q_dot, state, state_dot)
    !! Modal state at the first sample of each block.
    integer, intent(in) :: start(:)         !! samples before each block
    real(dp), intent(in) :: beta(:), q(:), q_dot(:)
    type(dd), intent(in) :: cycles(:)
    real(dp), intent(out) :: state(:, :), state_dot(:, :)
    real(dp), dimension(size(q)) :: angle, c, s
    integer :: b
    do b = 1, size(start)
      angle = phase_angles(cycles, start(b))
      c = cos(angle)
      s = sin(angle)
      state(:, b) = q*c + q_dot*(s/beta)
      state_dot(:, b) = q_dot*c - beta*q*s
    end do
  end subroutine states_at_blocks

  pure subroutine add_product(left, right, first, history)
    !! The product's columns are the blocks one after another: all but a last one that is cut short are added in place.
    real(dp), intent(in), contiguous :: left(:, :), right(:, :)
    integer, intent(in) :: first                  !! samples before the first of the product
    real(dp), intent(inout), contiguous :: history(:)
    real(dp) :: last(size(left, 1))
    integer :: columns, length, modes, rest
    length = size(left, 1)
    modes = size(left, 2)
    columns = min(size(right, 2), (size(history) - first)/length)
    if (columns > 0) call dgemm('N', 'N', length, columns, modes, 1.0_dp, left, length, right, modes, 1.0_dp, &
                                history(first + 1:first + length*columns), length)
    if (columns == size(right, 2)) return
    last = 0.0_dp
    call dgemm('N', 'N', length, 1, modes, 1.0_dp, left, length, right(:, columns + 1:), modes, 1.0_dp, last, length)
    rest = size(history) - first - length*columns
    history(size(history) - rest + 1:) = history(size(history) - rest + 1:) + last(:rest)
  end subroutine add_product

end module bw_modal_sum

module bw_modal_sum
  !! Histories of stable modes, \( v(\xi,t) = \sum_k \Phi_k(\xi)\,[q_k\cos\beta_k t + \dot q_k \sin\beta_k t/\beta_k]
  !! \), Eq. 29, by matrix products.
  !!
  !! Time is cut into blocks. The modal state at the middle of a block follows from a phase that is reduced modulo 2π
  !! before rounding. From there the phase of each mode changes alike in all blocks, forwards and backwards: sums of
  !! cosines are the even part of the motion about the middle, sums of sines the odd part, and their sum and difference
  !! the samples after it and before it. Each part of all blocks is one product of a table of cosines or sines with a
  !! table of states. As nothing is passed from sample to sample, no error grows with time.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, sqrt, operator(*), operator(/)
  use bw_mode_set, only: batch
  use bw_monitor, only: monitor_type, part_monitor
  use bw_time_grid, only: time_grid
  use bw_lapack, only: dgemm
  use bw_turn, only: turn_table
  implicit none (type, external)
  private
  public :: add_stable_modes, block_length

  integer, parameter :: chunk_blocks = 64     !! tuned: blocks per table of states

  type :: block_states
    !! Modal states at the middles of several blocks.
    integer :: first = 0                      !! samples before the first block
    integer :: blocks = 0
    real(dp), allocatable :: even(:, :)       !! of cos βs in the displacement: q, (modes, blocks, with room for more)
    real(dp), allocatable :: odd(:, :)        !! of sin βs: q̇/β
  end type block_states

  type :: block_turns
    !! Cosines and sines from the middle of a block to the samples after it, common to all blocks.
    real(dp), allocatable :: cosine(:, :), sine(:, :)   !! (samples of half a block, modes)
  end type block_turns

contains

  subroutine add_stable_modes(beta_squared, q, q_dot, shapes, grid, monitor, displacement, velocity)
    !! Add the motion from the modal state (q, q_dot) at t = 0. Returns early on a requested stop.
    type(dd), intent(in) :: beta_squared(:)         !! β² > 0, (modes)
    real(dp), intent(in) :: q(:), q_dot(:)          !! modal displacements and velocities at t = 0, (modes)
    real(dp), intent(in) :: shapes(:, :)            !! Φ_k(ξ_p), (modes, points)
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout), target :: monitor
    real(dp), intent(inout), contiguous :: displacement(:, :)   !! (samples, points)
    real(dp), intent(inout), optional, contiguous :: velocity(:, :)
    type(part_monitor) :: part
    real(dp) :: start(size(shapes, 2)), start_rate(size(shapes, 2))
    integer :: k, last
    start = displacement(1, :) + matmul(q, shapes)
    if (present(velocity)) start_rate = velocity(1, :) + matmul(q_dot, shapes)
    do k = 1, size(q), batch
      last = min(k + batch - 1, size(q))
      part = part_monitor(monitor, (k - 1.0_dp)/size(q), (last - k + 1.0_dp)/size(q))
      if (present(velocity)) then
        call add_batch(sqrt(beta_squared(k:last)), q(k:last), q_dot(k:last), shapes(k:last, :), grid, part, displacement, velocity)
      else
        call add_batch(sqrt(beta_squared(k:last)), q(k:last), q_dot(k:last), shapes(k:last, :), grid, part, displacement)
      end if
      if (monitor%stop_requested()) return
    end do
    displacement(1, :) = start            ! exact: 0 for an undeflected beam
    if (present(velocity)) velocity(1, :) = start_rate
  end subroutine add_stable_modes

  subroutine add_batch(beta, q, q_dot, shapes, grid, monitor, displacement, velocity)
    !! Add a few hundred modes.
    type(dd), intent(in) :: beta(:)
    real(dp), intent(in) :: q(:), q_dot(:), shapes(:, :)
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    real(dp), intent(inout), contiguous :: displacement(:, :)
    real(dp), intent(inout), optional, contiguous :: velocity(:, :)
    type(dd) :: cycles(size(q))           ! per half a sample: a block's middle lies between two samples
    type(block_turns) :: turns
    type(block_states) :: states
    integer :: first, length, p
    length = block_length(grid%samples)
    cycles = beta*(grid%step/(dd_pi*4.0_dp))
    call turns_in_block(length/2, cycles, turns)
    do first = 0, grid%samples - 1, length*chunk_blocks
      call states_at_blocks(first, length, grid%samples, cycles, q, q_dot/beta%hi, states)
      do p = 1, size(shapes, 2)
        call add_products(turns, states, shapes(:, p), states%even, shapes(:, p), states%odd, displacement(:, p))
        if (present(velocity)) call add_products(turns, states, beta%hi*shapes(:, p), states%odd, -beta%hi*shapes(:, p), &
                                                 states%even, velocity(:, p))
      end do
      call monitor%advance(real(first, dp)/grid%samples)
      if (monitor%stop_requested()) return
    end do
  end subroutine add_batch

  pure integer function block_length(samples) result(length)
    !! Return a power of two near √samples, which minimises the size of the two tables.
    integer, intent(in) :: samples
    length = 2**min(8, max(3, nint(0.5_dp*log(real(samples, dp))/log(2.0_dp))))
  end function block_length

  pure subroutine turns_in_block(half, cycles, turns)
    !! Tabulate cosines and sines of half a block, about its middle.
    integer, intent(in) :: half                     !! samples of half a block
    type(dd), intent(in) :: cycles(:)               !! cycles per half a sample
    type(block_turns), intent(out) :: turns
    real(dp), dimension(size(cycles), half) :: cosine, sine
    call turn_table(cycles, 1.0_dp, 2.0_dp, cosine, sine)
    turns%cosine = transpose(cosine)
    turns%sine = transpose(sine)
  end subroutine turns_in_block

  pure subroutine states_at_blocks(first, length, samples, cycles, start, start_rate, states)
    !! Find the states at the middles of the next blocks.
    integer, intent(in) :: first, length            !! samples before the first block, and in each
    integer, intent(in) :: samples
    type(dd), intent(in) :: cycles(:)               !! cycles per half a sample
    real(dp), intent(in), contiguous :: start(:), start_rate(:)   !! q and q̇/β at t = 0
    type(block_states), intent(inout) :: states
    real(dp), dimension(size(start), min(chunk_blocks, (samples - first + length - 1)/length)) :: cosine, sine
    integer :: b
    call turn_table(cycles, 2.0_dp*first + (length - 1), 2.0_dp*length, cosine, sine)
    if (.not. allocated(states%even)) allocate (states%even, states%odd, mold=cosine)
    do b = 1, size(cosine, 2)
      states%even(:, b) = start*cosine(:, b) + start_rate*sine(:, b)
      states%odd(:, b) = start_rate*cosine(:, b) - start*sine(:, b)
    end do
    states%first = first
    states%blocks = size(cosine, 2)
  end subroutine states_at_blocks

  pure subroutine add_products(turns, states, even_weight, even, odd_weight, odd, history)
    !! Add all samples of several blocks to one history.
    type(block_turns), intent(in) :: turns
    type(block_states), intent(in) :: states
    real(dp), intent(in), contiguous :: even_weight(:), odd_weight(:)   !! of the modes
    real(dp), intent(in), contiguous :: even(:, :), odd(:, :)   !! weighted amplitudes, (modes, blocks, with room for more)
    real(dp), intent(inout), contiguous :: history(:)       !! (samples)
    real(dp), dimension(size(turns%cosine, 1), states%blocks) :: cosines, sines
    real(dp) :: samples(2*size(turns%cosine, 1))
    integer :: b, before, count, half
    half = size(turns%cosine, 1)
    call multiply(turns%cosine, even_weight, even, cosines)
    call multiply(turns%sine, odd_weight, odd, sines)
    do b = 1, states%blocks
      before = states%first + 2*half*(b - 1)
      samples(half:1:-1) = cosines(:, b) - sines(:, b)
      samples(half + 1:) = cosines(:, b) + sines(:, b)
      count = min(2*half, size(history) - before)           ! the last block may be shorter
      history(before + 1:before + count) = history(before + 1:before + count) + samples(:count)
    end do
  end subroutine add_products

  pure subroutine multiply(left, weight, right, product)
    !! Return left·diag(weight)·right.
    real(dp), intent(in), contiguous :: left(:, :)          !! (samples of half a block, modes)
    real(dp), intent(in), contiguous :: weight(:), right(:, :)   !! (modes), (modes, blocks and more)
    real(dp), intent(out), contiguous :: product(:, :)      !! (samples of half a block, blocks)
    real(dp) :: weighted(size(right, 1), size(product, 2))
    integer :: b
    do b = 1, size(weighted, 2)
      weighted(:, b) = weight*right(:, b)
    end do
    call dgemm('N', 'N', size(left, 1), size(weighted, 2), size(left, 2), 1.0_dp, left, size(left, 1), weighted, &
               size(weighted, 1), 0.0_dp, product, size(product, 1))
  end subroutine multiply

end module bw_modal_sum

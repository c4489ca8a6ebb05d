module bw_damped_modes
  !! Histories of damped modes: q(t) = Re Σ a e^(st), with one complex exponential for an oscillating mode and two real
  !! ones for any other.
  !!
  !! Time is cut into blocks as in bw_modal_sum, and the samples of all blocks are one product of two tables:
  !! exponentials within a block, and states at the starts of blocks. Modes that have decayed are skipped.
  use bw_double_double, only: dd, dd_pi, sqrt, operator(*), operator(/)
  use bw_growing_modes, only: add_sample_by_sample
  use bw_kinds, only: dp
  use bw_modal_flow, only: fast_exponent, slow_exponent, turning_square
  use bw_mode_set, only: batch
  use bw_monitor, only: monitor_type
  use bw_time_grid, only: time_grid
  use bw_turn, only: phase_angles
  implicit none (type, external)
  private
  public :: add_damped_modes, grows

  integer, parameter :: length = 128            !! tuned: samples of a block
  integer, parameter :: chunk_blocks = 32       !! tuned
  real(dp), parameter :: dead = -60.0_dp        !! exponentials below e^(−60) of their start are negligible
  real(dp), parameter :: apart = 1.0e-4_dp      !! (2r/c)² above which two real exponentials hardly cancel

  type, public :: damped_motion
    !! Damped modes and their initial state.
    type(dd), allocatable :: beta_squared(:)    !! (modes)
    real(dp), allocatable :: c(:)               !! damping, (modes)
    real(dp), allocatable :: q(:), q_dot(:)     !! modal displacements and velocities at t = 0, (modes)
    real(dp), allocatable :: shapes(:, :)       !! Φ_k(ξ_p), (modes, points)
  end type damped_motion

  type :: exponentials
    !! A list of exponentials a e^(st).
    real(dp), allocatable :: decay(:)           !! Re s ≤ 0
    real(dp), allocatable :: turning(:)         !! Im s
    type(dd), allocatable :: cycles(:)          !! Im s/2π, cycles per sample
    complex(dp), allocatable :: start(:)        !! a
    integer, allocatable :: mode(:)             !! mode of each
  end type exponentials

contains

  elemental logical function grows(beta_squared, c, longest)
    !! Return whether a mode grows; bw_growing_modes sums the growing exponential of such modes.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c
    real(dp), intent(in) :: longest                 !! duration
    grows = beta_squared%hi < 0.0_dp .and. .not. is_close(beta_squared, c, longest)
  end function grows

  elemental logical function is_close(beta_squared, c, longest)
    !! Return whether a mode's two exponentials would cancel: near critical damping, or too slow.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c, longest
    type(dd) :: square
    square = turning_square(beta_squared, c)
    is_close = square%hi <= 0.0_dp .and. -square%hi <= max(apart*(0.5_dp*c)**2, (1.0_dp/longest)**2)
  end function is_close

  subroutine add_damped_modes(motion, grid, monitor, displacement, velocity)
    !! Add the motion; of growing modes only the decaying exponential. Returns early on a requested stop.
    type(damped_motion), intent(in) :: motion
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    real(dp), intent(inout) :: displacement(:, :)   !! (samples, points)
    real(dp), intent(inout), optional :: velocity(:, :)
    type(exponentials) :: list
    type(dd) :: square(size(motion%q))
    logical :: near(size(motion%q))
    integer :: first, last, k
    associate (beta_squared => motion%beta_squared, c => motion%c, q => motion%q, q_dot => motion%q_dot)
      square = turning_square(beta_squared, c)
      near = is_close(beta_squared, c, grid%samples*grid%step%hi)
      call find_exponentials(beta_squared, c, q, q_dot, square, near, grid, list)
      do first = 1, size(list%mode), batch
        last = min(first + batch - 1, size(list%mode))
        call add_exponentials(part_of(list, first, last), motion%shapes, grid, monitor, displacement, velocity)
        call monitor%advance(real(last, dp)/size(list%mode))
        if (monitor%stop_requested()) return
      end do
      do k = 1, size(q)
        if (.not. near(k)) cycle
        if (monitor%stop_requested()) return
        call add_sample_by_sample(beta_squared(k), c(k), q(k), q_dot(k), motion%shapes(k, :), grid, [1, grid%samples], &
                                  displacement, velocity)
      end do
    end associate
  end subroutine add_damped_modes

  pure subroutine find_exponentials(beta_squared, c, q, q_dot, square, near, grid, list)
    !! List oscillating modes first, then the slow and the fast exponentials of others.
    type(dd), intent(in) :: beta_squared(:), square(:)
    real(dp), intent(in) :: c(:), q(:), q_dot(:)
    logical, intent(in) :: near(:)
    type(time_grid), intent(in) :: grid
    type(exponentials), intent(out) :: list
    integer, allocatable :: turns(:), slow(:), fast(:)
    real(dp), allocatable :: still(:), parted(:), sine(:)
    type(dd), allocatable :: root(:)
    integer :: k
    turns = pack([(k, k=1, size(q))], square%hi > 0.0_dp)
    fast = pack([(k, k=1, size(q))], square%hi <= 0.0_dp .and. .not. near)
    slow = pack(fast, beta_squared(fast)%hi >= 0.0_dp)
    still = [(0.0_dp, k=1, size(slow) + size(fast))]
    root = sqrt(square(turns))
    sine = (q_dot(turns) + 0.5_dp*c(turns)*q(turns))/root%hi
    list%mode = [turns, slow, fast]
    list%turning = [root%hi, still]
    root = root*(grid%step/(dd_pi*2.0_dp))
    list%cycles = [root, (dd(), k=1, size(still))]
    list%decay = [-0.5_dp*c(turns), up_of(slow), down_of(fast)]
    parted = [amplitude(down_of(slow), up_of(slow), q(slow), q_dot(slow)), &
              amplitude(up_of(fast), down_of(fast), q(fast), q_dot(fast))]
    list%start = [cmplx(q(turns), -sine, dp), cmplx(parted, 0.0_dp, dp)]
  contains
    pure function up_of(m) result(exponent)
      !! Return the slower exponents of modes that do not oscillate.
      integer, intent(in) :: m(:)
      real(dp) :: exponent(size(m))
      type(dd) :: slow_part(size(m))
      slow_part = slow_exponent(beta_squared(m), c(m))
      exponent = slow_part%hi
    end function up_of
    pure function down_of(m) result(exponent)
      !! Return the faster exponents.
      integer, intent(in) :: m(:)
      real(dp) :: exponent(size(m))
      exponent = fast_exponent(beta_squared(m), c(m))
    end function down_of
  end subroutine find_exponentials

  elemental real(dp) function amplitude(other, own, q, q_dot)
    !! Return the amplitude of e^(own·t) in a motion of it and e^(other·t).
    real(dp), intent(in) :: other, own, q, q_dot
    amplitude = (q_dot - other*q)/(own - other)
  end function amplitude

  pure type(exponentials) function part_of(list, first, last) result(part)
    !! Return part of a list.
    type(exponentials), intent(in) :: list
    integer, intent(in) :: first, last
    part%decay = list%decay(first:last)
    part%turning = list%turning(first:last)
    part%cycles = list%cycles(first:last)
    part%start = list%start(first:last)
    part%mode = list%mode(first:last)
  end function part_of

  subroutine add_exponentials(list, shapes, grid, monitor, displacement, velocity)
    !! Add a batch of exponentials to histories, several blocks at a time.
    type(exponentials), intent(in) :: list
    real(dp), intent(in) :: shapes(:, :)
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    real(dp), intent(inout) :: displacement(:, :)
    real(dp), intent(inout), optional :: velocity(:, :)
    complex(dp) :: turn(length, size(list%mode)), state(size(list%mode), chunk_blocks)
    complex(dp) :: speed(size(list%mode))
    real(dp) :: time
    integer, allocatable :: alive(:)
    integer :: b, blocks, first, j, k, p
    do j = 1, length
      turn(j, :) = exponential(list%decay*(grid%step%hi*(j - 1)), phase_angles(list%cycles, j - 1))
    end do
    speed = cmplx(list%decay, list%turning, dp)
    do first = 0, grid%samples - 1, length*chunk_blocks
      alive = pack([(k, k=1, size(list%mode))], list%decay*(grid%step%hi*first) > dead)
      if (size(alive) == 0) return
      if (monitor%stop_requested()) return
      blocks = min(chunk_blocks, (grid%samples - first + length - 1)/length)
      do b = 1, blocks
        j = first + (b - 1)*length
        time = grid%step%hi*j
        state(:, b) = list%start*exponential(list%decay*time, phase_angles(list%cycles, j))
      end do
      do p = 1, size(shapes, 2)
        call add_product(turn(:, alive), alive, shapes(list%mode(alive), p), displacement(:, p))
      end do
      if (.not. present(velocity)) cycle
      state(:, :blocks) = spread(speed, 2, blocks)*state(:, :blocks)
      do p = 1, size(shapes, 2)
        call add_product(turn(:, alive), alive, shapes(list%mode(alive), p), velocity(:, p))
      end do
    end do
  contains
    subroutine add_product(turn, alive, shape, history)
      !! Add the blocks of one history.
      complex(dp), intent(in) :: turn(:, :)
      integer, intent(in) :: alive(:)
      real(dp), intent(in) :: shape(:)
      real(dp), intent(inout) :: history(:)
      complex(dp) :: right(size(alive), blocks)
      real(dp) :: product(length, blocks)
      integer :: count
      right = spread(shape, 2, blocks)*state(alive, :blocks)
      product = matmul(real(turn), real(right)) - matmul(aimag(turn), aimag(right))
      count = min(size(product), size(history) - first)
      history(first + 1:first + count) = history(first + 1:first + count) + reshape(product, [count])
    end subroutine add_product
  end subroutine add_exponentials

  elemental complex(dp) function exponential(exponent, angle) result(value)
    !! Return e^(exponent + i·angle).
    real(dp), intent(in) :: exponent, angle
    value = exp(exponent)*cmplx(cos(angle), sin(angle), dp)
  end function exponential

end module bw_damped_modes

module bw_nonuniform_sum
  !! Histories of many stable modes by a non-uniform fast Fourier transform, in modes + samples·log(samples) steps.
  !!
  !! Every mode, at its frequency modulo the sampling rate, is carried onto a uniform grid of frequencies with the
  !! kernel of bw_spreading_kernel; a fast transform turns the grid into samples, and what the kernel did to them is
  !! divided out. Histories are real, so frequencies are folded to 0 … ½ of the sampling rate and half the grid
  !! serves; frequencies, places and weights are those of all points, and of velocities. The phase that every mode has
  !! at the middle sample is taken exactly, so samples are counted from there, and the places too: nothing is lost to
  !! the length of the record.
  !!
  !! **Errors**: as `transform_error` says, over the peak, for modes that turn at least once in the record. The
  !! amplitude q̇/β of a slower one is larger than its motion, and the error follows the amplitude.
  !!
  !! **Source**: Dutt and Rokhlin (1993), doi:10.1137/0914081; Barnett, Magland and af Klinteberg (2019),
  !! doi:10.1137/18M120885X.
  use bw_kinds, only: dp, i8
  use bw_double_double, only: dd, dd_pi, sqrt, operator(*), operator(/)
  use bw_half_spectrum, only: half_spectrum_plan
  use bw_monitor, only: monitor_type
  use bw_spread, only: spread_modes
  use bw_spreading_kernel, only: kernel_damping, kernel_of, spreading_kernel
  use bw_time_grid, only: time_grid
  use bw_turn, only: phase_angles, turn_fractions
  implicit none (type, external)
  private
  public :: transform_stable_modes, points_at_once

  integer, parameter :: batch = 256                !! tuned: modes whose places and coefficients stay in the cache
  integer, parameter :: most_points = 16           !! tuned: whose coefficients of a batch stay in the cache
  integer, parameter :: most_kept = 2**20          !! numbers of the grids that a sum keeps for the next, 8 MB
  integer, parameter :: most_numbers = 2**23       !! of the grids in memory at a time, 64 MB; a single grid may be more

  type, public :: nonuniform_sum
    !! A sum under way: modes are added in as many parts as one likes, and turned into samples once. Opened again, it
    !! keeps the kernel, the plan and the memory of the last sum as far as they serve.
    private
    integer :: half = 0                            !! points of half the grid of frequencies
    integer :: points = 0                          !! of the beam
    type(time_grid) :: grid
    type(spreading_kernel) :: kernel
    type(half_spectrum_plan) :: plan
    real(dp), allocatable :: spectra(:, :)
      !! (2·(half + 1 + width), points), real and imaginary parts in turn; twice as many with velocities
    real(dp), allocatable :: start(:), start_dot(:)   !! the sum at t = 0, (points)
  contains
    procedure :: open => open_sum
    procedure :: add => add_modes
    procedure :: close => close_sum
    procedure :: shrink
  end type nonuniform_sum

contains

  subroutine transform_stable_modes(sum, beta_squared, q, q_dot, shapes, grid, width, half, monitor, displacement, velocity)
    !! Adds the motion that starts from the modal state (q, q_dot) at t = 0; leaves early if the monitor asks for it.
    type(nonuniform_sum), intent(inout) :: sum      !! any, also one that was used
    type(dd), intent(in) :: beta_squared(:)         !! β² > 0, (modes)
    real(dp), intent(in) :: q(:), q_dot(:)          !! modal displacements and velocities at t = 0, (modes)
    real(dp), intent(in) :: shapes(:, :)            !! Φ_k(ξ_p), (modes, points)
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: width                    !! of the kernel
    integer, intent(in) :: half                     !! points of half the grid of frequencies
    class(monitor_type), intent(inout) :: monitor
    real(dp), intent(inout) :: displacement(:, :)   !! (samples, points)
    real(dp), intent(inout), optional :: velocity(:, :)
    integer :: first, group, k, last, points
    points = size(shapes, 2)
    group = points_at_once(half, grid%samples, points, present(velocity))
    do first = 1, points, group
      last = min(first + group - 1, points)
      call sum%open(grid, width, half, last - first + 1, present(velocity))
      do k = 1, size(q), batch
        associate (e => min(k + batch - 1, size(q)))
          call sum%add(sqrt(beta_squared(k:e)), q_dot(k:e), shapes(k:e, first:last), q(k:e))
          call monitor%advance((first - 1 + (last - first + 1)*(real(e, dp)/size(q)))/points)
        end associate
        if (monitor%stop_requested()) return
      end do
      if (present(velocity)) then
        call sum%close(displacement(:, first:last), velocity(:, first:last))
      else
        call sum%close(displacement(:, first:last))
      end if
    end do
    call sum%shrink()
  end subroutine transform_stable_modes

  pure integer function points_at_once(half, samples, points, with_velocity) result(group)
    !! For how many points the grids may be in memory together: they take no more than the histories do themselves, or 64 MB.
    integer, intent(in) :: half, samples, points
    logical, intent(in) :: with_velocity
    integer(i8) :: numbers
    integer :: kinds
    kinds = merge(2, 1, with_velocity)
    numbers = max(int(most_numbers, i8), int(samples, i8)*points*kinds)
    group = int(max(1_i8, min(int(min(points, most_points), i8), numbers/(2_i8*half*kinds))))
  end function points_at_once

  subroutine open_sum(self, grid, width, half, points, with_velocity)
    class(nonuniform_sum), intent(inout) :: self
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: width                    !! of the kernel
    integer, intent(in) :: half                     !! points of half the grid of frequencies
    integer, intent(in) :: points                   !! of the beam
    logical, intent(in) :: with_velocity
    integer :: histories
    logical :: known
    known = self%kernel%width == width .and. self%half == half .and. self%grid%samples == grid%samples
    if (.not. known) self%kernel = kernel_of(width, 2.0_dp*half/grid%samples)
    histories = points*merge(2, 1, with_velocity)
    if (allocated(self%spectra)) then
      if (any(shape(self%spectra) /= [2*(half + 1 + width), histories])) deallocate (self%spectra)
    end if
    if (.not. allocated(self%spectra)) allocate (self%spectra(2*(half + 1 + width), histories))
    self%spectra = 0.0_dp
    self%half = half
    self%points = points
    self%grid = grid
    self%start = spread(0.0_dp, 1, points)
    self%start_dot = self%start
  end subroutine open_sum

  subroutine close_sum(self, displacement, velocity)
    !! Adds the samples to histories.
    class(nonuniform_sum), intent(inout) :: self
    real(dp), intent(inout) :: displacement(:, :)   !! (samples, points)
    real(dp), intent(inout), optional :: velocity(:, :)
    integer :: zero
    zero = self%kernel%width + 1                    ! real part at frequency 0
    call fold_ends(self%half, self%kernel%width, self%spectra)
    call self%plan%samples(self%half, self%spectra(zero:zero + 2*self%half + 1, :))
    call add_samples(self%kernel, self%half, self%spectra(zero:zero + 2*self%half - 1, :self%points), self%start, &
                     displacement)
    if (present(velocity)) call add_samples(self%kernel, self%half, &
                                            self%spectra(zero:zero + 2*self%half - 1, self%points + 1:), &
                                            self%start_dot, velocity)
  end subroutine close_sum

  subroutine shrink(self)
    !! Give back the memory of large grids.
    class(nonuniform_sum), intent(inout) :: self
    if (.not. allocated(self%spectra)) return
    if (size(self%spectra) > most_kept) deallocate (self%spectra)
  end subroutine shrink

  subroutine add_modes(self, beta, q_dot, shapes, q)
    !! Adds modes to the grids of displacements and, where they are asked for, of velocities.
    class(nonuniform_sum), intent(inout) :: self
    type(dd), intent(in) :: beta(:)                 !! β > 0, (modes)
    real(dp), intent(in) :: q_dot(:)                !! modal velocities at t = 0, (modes)
    real(dp), intent(in) :: shapes(:, :)            !! Φ_k(ξ_p), (modes, points)
    real(dp), intent(in), optional :: q(:)          !! modal displacements at t = 0, (modes); absent: at rest
    real(dp), dimension(batch) :: offset, side, c, s, re, im, rate
    type(dd) :: turns
    integer :: place(batch), first, last, n, p
    turns = self%grid%step/(dd_pi*2.0_dp)
    do first = 1, size(beta), batch
      last = min(first + batch - 1, size(beta))
      n = last - first + 1
      call phases_at_middle(beta(first:last)*turns, self%grid%samples/2, 2*self%half, place(:n), offset(:n), side(:n), &
                            c(:n), s(:n))
      rate(:n) = side(:n)*beta(first:last)%hi
      im(:n) = q_dot(first:last)/beta(first:last)%hi
      re(:n) = im(:n)*s(:n)
      im(:n) = -side(:n)*im(:n)*c(:n)
      if (present(q)) then
        re(:n) = re(:n) + q(first:last)*c(:n)
        im(:n) = im(:n) + side(:n)*q(first:last)*s(:n)
      end if
      call spread_modes(self%kernel, place(:n) + 2, offset(:n), re(:n), im(:n), rate(:n), shapes(first:last, :), &
                        self%spectra)
    end do
    do p = 1, self%points
      if (present(q)) self%start(p) = self%start(p) + dot_product(q, shapes(:, p))
      if (size(self%spectra, 2) > self%points) self%start_dot(p) = self%start_dot(p) + dot_product(q_dot, shapes(:, p))
    end do
  end subroutine add_modes

  pure subroutine phases_at_middle(cycles, middle, points, place, offset, side, c, s)
    !! Where modes lie on the grid of `points` frequencies of a turn, and their phases at the middle sample. A frequency
    !! above half the sampling rate is that of the mirrored phase.
    type(dd), intent(in) :: cycles(:)         !! turns per sample
    integer, intent(in) :: middle             !! sample from which samples are counted
    integer, intent(in) :: points
    integer, intent(out) :: place(:)          !! grid point to the left of the mode, from 0
    real(dp), intent(out) :: offset(:)        !! way from there to the mode, 0 … 1 spacings
    real(dp), intent(out) :: side(:)          !! −1 for a mirrored phase, else 1
    real(dp), intent(out) :: c(:), s(:)       !! cosine and sine of the phase itself
    type(dd) :: fraction(size(cycles)), position(size(cycles))
    real(dp) :: angle(size(cycles))
    fraction = turn_fractions(cycles)
    angle = phase_angles(fraction, middle)
    c = cos(angle)
    s = sin(angle)
    side = sign(1.0_dp, fraction%hi)
    position = fraction*real(points, dp)
    place = int(abs(position%hi))
    offset = (abs(position%hi) - place) + side*position%lo
  end subroutine phases_at_middle

  pure subroutine fold_ends(half, width, spectra)
    !! What was carried below frequency 0 or above half the sampling rate belongs to the conjugate of its mirror image.
    integer, intent(in) :: half, width
    real(dp), intent(inout), contiguous :: spectra(:, :)
    integer :: m, zero, top
    zero = width + 1                   ! real part at frequency 0
    top = zero + 2*half
    do m = 0, width/2
      call add_conjugate(spectra(zero + 2*m:zero + 2*m + 1, :), spectra(zero - 2*m:zero - 2*m + 1, :))
      call add_conjugate(spectra(top - 2*m:top - 2*m + 1, :), spectra(top + 2*m:top + 2*m + 1, :))
    end do
  end subroutine fold_ends

  pure subroutine add_conjugate(kept, image)
    real(dp), intent(inout) :: kept(:, :)
    real(dp), intent(in) :: image(:, :)
    kept(1, :) = kept(1, :) + image(1, :)
    kept(2, :) = kept(2, :) - image(2, :)
  end subroutine add_conjugate

  pure subroutine add_samples(kernel, half, samples, start, history)
    !! Divides the kernel out; samples before the middle are the last ones of the transform. The first sample is the
    !! state at t = 0 itself: what starts from rest is at rest there.
    type(spreading_kernel), intent(in) :: kernel
    integer, intent(in) :: half
    real(dp), intent(in) :: samples(0:, :)            !! (2·half, points)
    real(dp), intent(in) :: start(:)                  !! sum at t = 0, (points)
    real(dp), intent(inout) :: history(0:, :)         !! (samples, points)
    integer, parameter :: block = 512                 ! tuned, as `batch`
    real(dp) :: factor(0:block - 1)
    integer :: first, j, last, middle, p
    middle = size(history, 1)/2
    history(0, :) = history(0, :) + start
    do first = 0, middle, block
      last = min(first + block - 1, middle)
      factor(:last - first) = 0.5_dp/kernel_damping(kernel, first, last - first + 1, 2*half)
      do p = 1, size(history, 2)
        do j = max(first, 1 - middle), min(last, size(history, 1) - 1 - middle)
          history(middle + j, p) = history(middle + j, p) + factor(j - first)*samples(j, p)
        end do
        do j = max(first, 1), min(last, middle - 1)
          history(middle - j, p) = history(middle - j, p) + factor(j - first)*samples(2*half - j, p)
        end do
      end do
    end do
  end subroutine add_samples

end module bw_nonuniform_sum

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
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, sqrt, operator(*), operator(/)
  use bw_half_spectrum, only: samples_of_half_spectra
  use bw_monitor, only: monitor_type
  use bw_spread, only: spread_modes
  use bw_spreading_kernel, only: kernel_damping, kernel_of, spreading_kernel
  use bw_time_grid, only: time_grid
  use bw_turn, only: phase_angles, turn_fractions
  implicit none (type, external)
  private
  public :: transform_stable_modes

  integer, parameter :: batch = 256                !! tuned: modes whose places and coefficients stay in the cache
  integer, parameter :: most_points = 16           !! tuned: whose coefficients of a batch stay in the cache
  integer, parameter :: most_numbers = 2**23       !! of the grids in memory at a time, 64 MB; a single grid may be more

contains

  subroutine transform_stable_modes(beta_squared, q, q_dot, shapes, grid, width, half, monitor, displacement, velocity)
    !! Adds the motion that starts from the modal state (q, q_dot) at t = 0; leaves early if the monitor asks for it.
    type(dd), intent(in) :: beta_squared(:)         !! β² > 0, (modes)
    real(dp), intent(in) :: q(:), q_dot(:)          !! modal displacements and velocities at t = 0, (modes)
    real(dp), intent(in) :: shapes(:, :)            !! Φ_k(ξ_p), (modes, points)
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: width                    !! of the kernel
    integer, intent(in) :: half                     !! points of half the grid of frequencies
    class(monitor_type), intent(inout) :: monitor
    real(dp), intent(inout) :: displacement(:, :)   !! (samples, points)
    real(dp), intent(inout), optional :: velocity(:, :)
    type(spreading_kernel) :: kernel
    real(dp), allocatable :: spectra(:, :)
    integer :: first, last, group, kinds, points
    points = size(shapes, 2)
    kernel = kernel_of(width, 2.0_dp*half/grid%samples)
    kinds = merge(2, 1, present(velocity))
    group = max(1, min(points, most_points, most_numbers/(2*half*kinds)))
    do first = 1, points, group
      last = min(first + group - 1, points)
      allocate (spectra(2*(half + 1 + width), kinds*(last - first + 1)), source=0.0_dp)
      call spread_all(beta_squared, q, q_dot, shapes(:, first:last), grid, half, kernel, monitor, spectra)
      if (monitor%stop_requested()) return
      call fold_ends(half, width, spectra)
      call samples_of_half_spectra(half, spectra(width + 1:width + 2*(half + 1), :))
      call add_samples(kernel, half, spectra(width + 1:width + 2*half, :last - first + 1), &
                       matmul(q, shapes(:, first:last)), displacement(:, first:last))
      if (present(velocity)) call add_samples(kernel, half, spectra(width + 1:width + 2*half, last - first + 2:), &
                                              matmul(q_dot, shapes(:, first:last)), velocity(:, first:last))
      deallocate (spectra)
    end do
  end subroutine transform_stable_modes

  subroutine spread_all(beta_squared, q, q_dot, shapes, grid, half, kernel, monitor, spectra)
    !! All modes onto the grids of displacements and, where there are twice as many grids as points, of velocities.
    type(dd), intent(in) :: beta_squared(:)
    real(dp), intent(in) :: q(:), q_dot(:), shapes(:, :)
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: half
    type(spreading_kernel), intent(in) :: kernel
    class(monitor_type), intent(inout) :: monitor
    real(dp), intent(inout), contiguous :: spectra(:, :)
    type(dd) :: turns, beta(batch)
    real(dp), dimension(batch) :: offset, re, im, rate
    integer :: place(batch)
    real(dp) :: coefficient(2, size(spectra, 2), batch)
    integer :: first, last, n, p, points
    turns = grid%step/(dd_pi*2.0_dp)
    points = size(shapes, 2)
    do first = 1, size(q), batch
      last = min(first + batch - 1, size(q))
      n = last - first + 1
      beta(:n) = sqrt(beta_squared(first:last))
      call state_at_middle(beta(:n)%hi, beta(:n)*turns, grid%samples/2, 2*half, q(first:last), q_dot(first:last), &
                           place(:n), offset(:n), re(:n), im(:n), rate(:n))
      do p = 1, points
        coefficient(1, p, :n) = shapes(first:last, p)*re(:n)
        coefficient(2, p, :n) = shapes(first:last, p)*im(:n)
        if (size(spectra, 2) == points) cycle
        coefficient(1, points + p, :n) = -rate(:n)*coefficient(2, p, :n)
        coefficient(2, points + p, :n) = rate(:n)*coefficient(1, p, :n)
      end do
      call spread_modes(kernel, place(:n) + 2, offset(:n), coefficient(:, :, :n), spectra)
      call monitor%advance(real(last, dp)/size(q))
      if (monitor%stop_requested()) return
    end do
  end subroutine spread_all

  pure subroutine state_at_middle(beta, cycles, middle, points, q, q_dot, place, offset, re, im, rate)
    !! Where modes lie on the grid of `points` frequencies of a turn, and what turns with e^(iβt): its real part is
    !! the modal displacement. A frequency above half the sampling rate is that of the mirrored phase.
    real(dp), intent(in) :: beta(:)
    type(dd), intent(in) :: cycles(:)         !! turns per sample
    integer, intent(in) :: middle             !! sample from which samples are counted
    integer, intent(in) :: points
    real(dp), intent(in) :: q(:), q_dot(:)
    integer, intent(out) :: place(:)          !! grid point to the left of the mode, from 0
    real(dp), intent(out) :: offset(:)        !! way from there to the mode, 0 … 1 spacings
    real(dp), intent(out) :: re(:), im(:)
    real(dp), intent(out) :: rate(:)          !! ±β, below zero for a mirrored phase
    type(dd) :: fraction(size(beta)), position(size(beta))
    real(dp), dimension(size(beta)) :: angle, c, s, side
    fraction = turn_fractions(cycles)
    angle = phase_angles(fraction, middle)
    side = sign(1.0_dp, fraction%hi)
    position = fraction*real(points, dp)
    place = int(abs(position%hi))
    offset = (abs(position%hi) - place) + side*position%lo
    c = cos(angle)
    s = sin(angle)
    re = q*c + q_dot/beta*s
    im = side*(q*s - q_dot/beta*c)
    rate = side*beta
  end subroutine state_at_middle

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

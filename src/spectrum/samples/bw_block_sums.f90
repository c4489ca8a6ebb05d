module bw_block_sums
  !! Sums of exponentials over blocks of a record's samples.
  !!
  !! Even blocks differ by a factor and by where they start. Of long uneven blocks a few moments are known, which stand for the
  !! samples where an exponential turns little against a reference: its series is summed instead. Other sums take every sample.
  use bw_kinds, only: dp
  use bw_samples, only: bent_factor, bent_series, centre_of, find_wave, phase_factor, samples_type, series, span_of
  implicit none (type, external)
  private
  public :: block_sums, even_blocks, find_moments, part_of

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: table = 32           !! factors of the fine one of two tables
  real(dp), parameter :: most_turned = 0.4_dp  !! of an exponent in half a block, so that its series leaves 1e-9
  integer, parameter :: at_once = 64         !! blocks whose series fit a processor's cache
  integer, parameter :: fewest = 16          !! samples of a block for each of which moments are worth while

  integer, parameter :: highest = series + 6 !! power of time in a moment: a line's slopes take six

  type, public :: blocks_type
    integer, allocatable :: first(:)         !! index of the first sample of each block, and N + 1, (B + 1)
    real(dp), allocatable :: middle(:)       !! u there, of uneven samples, (B)
    real(dp) :: reach = huge(1.0_dp)         !! of u from there in the longest block
    real(dp), allocatable :: reference(:)    !! frequencies g, in periods per step, of the moments, (G)
    complex(dp), allocatable :: moment(:, :, :)  !! Σ (u − middle)^p e^(2πigτ) over a block, (0:highest, B, G)
  end type blocks_type

contains

  pure function even_blocks(samples, count) result(blocks)
    !! About so many blocks of the same length in time; of uneven samples those without a sample are left out.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: count
    type(blocks_type) :: blocks
    integer, allocatable :: block(:)
    integer :: length, samples_in_all, n
    samples_in_all = samples%count
    if (.not. allocated(samples%place)) then
      length = max(1, samples_in_all/count)
      blocks%first = [(n, n=1, samples_in_all, length), samples_in_all + 1]
    else if (count >= samples_in_all) then
      blocks%first = [(n, n=1, samples_in_all + 1)]
    else
      block = int(samples%place*(count/span_of(samples)))
      blocks%first = [1, pack([(n, n=2, samples_in_all)], block(2:) > block(:samples_in_all - 1)), samples_in_all + 1]
    end if
  end function even_blocks

  function block_sums(samples, blocks, decay, frequency, order, bend) result(sums)
    !! The sums Σ u^m e^(−dτ + 2πifτ) over the samples of each block, m = 0 … order, (B, 0:order), times the factor of a bend.
    !! A line that grows is divided by its last value, so that nothing overflows.
    type(samples_type), intent(in) :: samples
    type(blocks_type), intent(in) :: blocks
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: order
    complex(dp), intent(in) :: bend(2:)      !! of size 0 where the line does not drift
    complex(dp) :: sums(size(blocks%first) - 1, 0:order)
    integer :: near
    near = 0
    if (allocated(blocks%reference)) near = minloc(abs(blocks%reference - frequency), dim=1)
    if (near > 0) then
      if (abs(cmplx(decay, 2*pi*(frequency - blocks%reference(near)), dp))*centre_of(samples)*blocks%reach > most_turned) near = 0
    end if
    if (near > 0) then
      sums = sums_of_moments(blocks, near, centre_of(samples), decay, frequency, order, bend)
    else if (allocated(samples%place)) then
      sums = uneven_sums(samples, blocks, decay, frequency, order, bend)
    else
      sums = even_sums(samples%count, blocks, decay, frequency, order, bend)
    end if
  end function block_sums

  pure function even_sums(count, blocks, decay, frequency, order, bend) result(sums)
    !! All blocks but the last have one length, so that their sums differ by a factor and by where u starts.
    integer, intent(in) :: count, order
    type(blocks_type), intent(in) :: blocks
    real(dp), intent(in) :: decay, frequency
    complex(dp), intent(in) :: bend(2:)
    complex(dp) :: sums(size(blocks%first) - 1, 0:order)
    complex(dp) :: factor(size(blocks%first) - 1), moment(0:order + merge(series, 0, size(bend) > 0))
    real(dp) :: centre, u(size(blocks%first) - 1)
    integer :: b, j, m, length, start
    centre = max(count - 1, 1)/2.0_dp
    start = blocks%first(1) - 1
    length = blocks%first(2) - blocks%first(1)
    if (decay < 0) then                        ! powers alone would overflow
      factor = powers(0.0_dp, frequency, length, size(factor))*phase_factor(frequency, start)* &
        & [(exp(decay*(count - 1 - start - real(b, dp)*length)), b=0, size(factor) - 1)]
    else
      factor = powers(decay, frequency, length, size(factor))*exp(-decay*start)*phase_factor(frequency, start)
    end if
    moment = moments(decay, frequency, length, centre, ubound(moment, 1))
    u = [((blocks%first(b) - 1 - centre)/centre, b=1, size(u))]
    if (size(bend) == 0) then
      do m = 0, order
        sums(:, m) = moment(m)
      end do
    else
      sums = bent(moment, bend, u, order)
    end if
    b = size(u)                                ! the last block may be shorter
    if (length /= blocks%first(b + 1) - blocks%first(b)) then
      moment = moments(decay, frequency, blocks%first(b + 1) - blocks%first(b), centre, ubound(moment, 1))
      if (size(bend) == 0) then
        sums(b, :) = moment
      else
        sums(b:, :) = bent(moment, bend, u(b:), order)
      end if
    end if
    do m = 1, order                            ! about the record's middle, by the binomial theorem
      do j = order, m, -1
        sums(:, j) = sums(:, j) + u*sums(:, j - 1)
      end do
    end do
    do m = 0, order
      sums(:, m) = factor*sums(:, m)
    end do
  end function even_sums

  pure function bent(moment, bend, u, order) result(about)
    !! Moments that several blocks have from where they start, with the factor of a bend, (blocks, 0:order).
    complex(dp), intent(in) :: moment(0:), bend(2:)
    real(dp), intent(in) :: u(:)             !! where these start
    integer, intent(in) :: order
    complex(dp) :: about(size(u), 0:order), a(at_once, 0:series)
    integer :: first, last, m, j, b
    do first = 1, size(u), at_once
      last = min(size(u), first + at_once - 1)
      a(:last - first + 1, :) = bent_series(bend, u(first:last))
      do m = 0, order
        about(first:last, m) = 0
        do j = 0, series
          about(first:last, m) = about(first:last, m) + a(:last - first + 1, j)*moment(m + j)
        end do
      end do
    end do
    do b = 1, size(u)
      about(b, :) = bent_factor(bend, u(b))*about(b, :)
    end do
  end function bent

  pure function moments(decay, frequency, length, centre, order) result(moment)
    !! The sums Σ (l/centre)^m e^(−dl + 2πifl) of a block, l = 0 … length − 1, (0:order).
    real(dp), intent(in) :: decay, frequency, centre
    integer, intent(in) :: length, order
    complex(dp) :: moment(0:order), term(length)
    integer :: l, m
    term = powers(decay, frequency, 1, length)
    do m = 0, order
      moment(m) = sum(term)
      if (m < order) term = term*[(l/centre, l=0, length - 1)]
    end do
  end function moments

  pure function shifted(moment, start) result(about)
    !! Moments about another point, by the binomial theorem.
    complex(dp), intent(in) :: moment(0:)
    real(dp), intent(in) :: start
    complex(dp) :: about(0:size(moment) - 1)
    integer :: m, j
    about = moment
    do j = 1, size(moment) - 1
      do m = size(moment) - 1, j, -1
        about(m) = about(m) + start*about(m - 1)
      end do
    end do
  end function shifted

  pure function powers(decay, frequency, stride, count) result(factor)
    !! The factors e^(−dn + 2πifn) of n = 0, stride, 2 stride, …: the product of a fine and a coarse table.
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: stride, count
    complex(dp) :: factor(0:count - 1), fine(0:table - 1), coarse
    integer :: b, last
    fine = [(exp(-decay*b*stride)*phase_factor(frequency, b*stride), b=0, table - 1)]
    do b = 0, count - 1, table
      last = min(count, b + table) - 1
      coarse = exp(-decay*(real(b, dp)*stride))*phase_factor(frequency, b*stride)
      factor(b:last) = coarse*fine(:last - b)
    end do
  end function powers

  pure subroutine find_moments(samples, references, blocks)
    !! Find the moments of blocks of uneven samples, if these are long: they stand for the samples in sums of any exponential that
    !! turns little against one of the references within a block.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: references(:)
    type(blocks_type), intent(inout) :: blocks
    real(dp), allocatable :: along(:), across(:), u(:)
    real(dp) :: centre
    integer :: b, g, p
    associate (count => size(blocks%first) - 1)
      if (samples%count < fewest*count) return
      blocks%reference = references
      allocate (blocks%middle(count), blocks%moment(0:highest, count, size(references)))
    end associate
    centre = centre_of(samples)
    blocks%reach = 0
    do b = 1, size(blocks%middle)
      associate (place => samples%place(blocks%first(b):blocks%first(b + 1) - 1))
        blocks%middle(b) = (place(1) + place(size(place)))/(2*centre) - 1
        allocate (along(size(place)), across(size(place)), u(size(place)))
        u(:) = place/centre - 1 - blocks%middle(b)
        blocks%reach = max(blocks%reach, u(size(u)))
        do g = 1, size(references)
          call find_wave(place, centre, 0.0_dp, references(g), [complex(dp) ::], along, across)
          do p = 0, highest
            blocks%moment(p, b, g) = cmplx(sum(along), sum(across), dp)
            along = along*u
            across = across*u
          end do
        end do
        deallocate (along, across, u)
      end associate
    end do
  end subroutine find_moments

  pure function part_of(blocks, low, high) result(part)
    !! Some of the blocks.
    type(blocks_type), intent(in) :: blocks
    integer, intent(in) :: low, high         !! the first and the last
    type(blocks_type) :: part
    part%first = blocks%first(low:high + 1)
    if (.not. allocated(blocks%reference)) return
    part%reference = blocks%reference
    part%reach = blocks%reach
    part%middle = blocks%middle(low:high)
    part%moment = blocks%moment(:, low:high, :)
  end function part_of

  pure function sums_of_moments(blocks, g, centre, decay, frequency, order, bend) result(sums)
    !! Block by block, where an exponential turns little against a reference.
    type(blocks_type), intent(in) :: blocks
    integer, intent(in) :: g                 !! which
    real(dp), intent(in) :: centre           !! τ_c
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: order
    complex(dp), intent(in) :: bend(2:)
    complex(dp), dimension(size(blocks%first) - 1, 0:order) :: sums
    complex(dp) :: rate, about(0:order), a(size(sums, 1), 0:series)
    integer :: b, m
    rate = cmplx(-decay, 2*pi*(frequency - blocks%reference(g)), dp)*centre
    a = bent_series(bend, blocks%middle, rate)
    do b = 1, size(sums, 1)
      do m = 0, order
        about(m) = sum(a(b, :)*blocks%moment(m:m + series, b, g))
      end do
      associate (u => blocks%middle(b))
        sums(b, :) = exp(rate*(u + 1) + 2*min(decay, 0.0_dp)*centre)*bent_factor(bend, u)*shifted(about, u)
      end associate
    end do
  end function sums_of_moments

  pure function uneven_sums(samples, blocks, decay, frequency, order, bend) result(sums)
    !! Sample by sample.
    type(samples_type), intent(in) :: samples
    type(blocks_type), intent(in) :: blocks
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: order
    complex(dp), intent(in) :: bend(2:)
    complex(dp) :: sums(size(blocks%first) - 1, 0:order)
    real(dp), allocatable :: along(:), across(:)
    real(dp) :: centre
    integer :: b, m
    centre = centre_of(samples)
    do b = 1, size(sums, 1)
      associate (place => samples%place(blocks%first(b):blocks%first(b + 1) - 1))
        if (allocated(along)) then
          if (size(along) /= size(place)) deallocate (along, across)
        end if
        if (.not. allocated(along)) allocate (along(size(place)), across(size(place)))
        call find_wave(place, centre, decay, frequency, bend, along, across)
        do m = 0, order
          sums(b, m) = cmplx(sum(along), sum(across), dp)
          if (m == order) exit
          along = along*(place/centre - 1)
          across = across*(place/centre - 1)
        end do
      end associate
    end do
  end function uneven_sums

end module bw_block_sums
